#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frame/camera.h"
#include "frame/image.h"
#include "sim/sensor.h"

namespace hgg {

/// A camera on a body.
struct SimCamera {
  std::string name = "front";
  CameraModel model;
  Pose T_body_camera = Pose::Identity();
  bool depth = false;  // measures depth, with these errors
  RangeErrors errors;
};

/// An RGB-D camera that looks forward, 70 degrees wide.
SimCamera depthCamera();
/// 1..3 cameras around the body, 90 degrees wide: front, left, right.
std::vector<SimCamera> rigCameras(int count);

RayGrid cameraGrid(const SimCamera& camera);

/// The pixel that sees a body-frame point; nullopt when none does (occlusion is not looked at).
std::optional<Pixel> project(const SimCamera& camera, const Vec3& p_body);
/// The body-frame point at `depth` m along the optical axis.
Vec3 unproject(const SimCamera& camera, const Pixel& pixel, double depth);

/// The scan of a camera's grid as depths. Depths beyond 65 m are not measured.
DepthImage depthImage(const RayGrid& grid, const Scan& scan, Micros utime_us);

/// A rig.toml (docs/rig.md) of these cameras, and of a LiDAR at the body's origin if there is one. Returns an error
/// line, empty when done.
std::string writeRig(const std::vector<SimCamera>& cameras, bool has_lidar, const std::string& path);

}  // namespace hgg
