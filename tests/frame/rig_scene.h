#pragma once

#include <string>
#include <vector>

#include "core/units.h"
#include "frame/image.h"
#include "frame/rig.h"

namespace hgg::rig_scene {

constexpr ClassId kCar = 10, kRoad = 40, kWall = 50;

/// A camera at the body's origin, 320 x 240, 90 degrees wide, that looks `yaw` to the left; its numbers are those of
/// the shipped class table.
inline RigCamera camera(const std::string& name, double yaw) {
  RigCamera camera;
  camera.name = name;
  camera.labels = "CAMERA_LABELS_" + name;
  camera.model.fx = camera.model.fy = 160;
  camera.model.cx = 159.5, camera.model.cy = 119.5;
  camera.T_body_camera.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix() * cameraAxes();
  camera.label_set.class_of.assign(300, LabelSet::kForeign);
  for (const ClassId id : {kCar, kRoad, kWall}) {
    camera.label_set.class_of[id] = id;
  }
  camera.label_set.class_of[0] = kUnknownClass;
  return camera;
}

inline LabelImage blank(const RigCamera& camera, ClassId label) {
  LabelImage image;
  image.width = camera.model.width, image.height = camera.model.height;
  image.labels.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), label);
  return image;
}

/// A square that faces the body `x` m ahead, from -half to half, a point every 5 cm.
inline std::vector<Point> face(float x, float half) {
  constexpr float kStep = 0.05F;
  std::vector<Point> points;
  for (float y = -half; y <= half; y += kStep) {
    for (float z = -half; z <= half; z += kStep) {
      points.push_back({x, y, z, 0, 0});
    }
  }
  return points;
}

}  // namespace hgg::rig_scene
