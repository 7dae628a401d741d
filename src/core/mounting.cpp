#include "core/mounting.h"

#include <numbers>

namespace hgg {

std::array<double, 6> numbersOf(const Mounting& m) { return {m.x, m.y, m.z, m.roll_deg, m.pitch_deg, m.yaw_deg}; }

Mounting mountingOf(const std::array<double, 6>& n) { return {n[0], n[1], n[2], n[3], n[4], n[5]}; }

Pose poseOf(const Mounting& m) {
  constexpr double kRadians = std::numbers::pi / 180;
  const Eigen::AngleAxisd roll(m.roll_deg * kRadians, Vec3::UnitX()), pitch(m.pitch_deg * kRadians, Vec3::UnitY()),
      yaw(m.yaw_deg * kRadians, Vec3::UnitZ());
  Pose T_body_sensor = Pose::Identity();
  T_body_sensor.translation() = Vec3(m.x, m.y, m.z);
  T_body_sensor.linear() = (yaw * pitch * roll).toRotationMatrix();
  return T_body_sensor;
}

}  // namespace hgg
