#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frame/image.h"
#include "sim/sensor.h"

namespace hgg {

/// A pinhole camera without distortion; x right, y down, z forward. Pixel (x, y) covers x-0.5 .. x+0.5.
struct CameraModel {
  std::string name = "front";
  int width = 320, height = 240;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixel
  Pose T_body_camera = Pose::Identity();
  bool depth = false;  // measures depth, with these errors
  RangeErrors errors;
};

/// Camera axes (x right, y down, z forward) in body axes (x forward, y left, z up).
Mat3 cameraAxes();

/// An RGB-D camera that looks forward, 70 degrees wide.
CameraModel depthCamera();
/// 1..3 cameras around the body, 90 degrees wide: front, left, right.
std::vector<CameraModel> rigCameras(int count);

RayGrid cameraGrid(const CameraModel& camera);

struct Pixel {
  int x = 0, y = 0;
};
/// The pixel that sees a body-frame point; nullopt when none does (occlusion is not looked at).
std::optional<Pixel> project(const CameraModel& camera, const Vec3& p_body);
/// The body-frame point at `depth` m along the optical axis.
Vec3 unproject(const CameraModel& camera, const Pixel& pixel, double depth);

/// The scan of a camera's grid as depths. Depths beyond 65 m are not measured.
DepthImage depthImage(const RayGrid& grid, const Scan& scan, Micros utime_us);

/// A rig.toml: what turns images into points. Returns an error line, empty when done.
std::string writeRig(const std::vector<CameraModel>& cameras, const std::string& path);

}  // namespace hgg
