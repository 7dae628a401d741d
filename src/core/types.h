#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace hgg {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// Rigid transform; `T_a_b` maps coordinates of frame b into frame a.
using Pose = Eigen::Isometry3d;
/// Time of measurement in microseconds (the unit of the wire).
using Micros = std::int64_t;
using ClassId = std::uint16_t;

/// A labelled point in the body frame. `instance` is 0 when the segmenter gave none.
struct Point {
  float x, y, z;
  std::uint32_t instance;
  ClassId label;
};

/// A point of one instance or class: x, y, z and a padding zero, so that four lanes load at once.
using PackedPoint = Eigen::Array4f;

}  // namespace hgg
