#include <bot_core/pose_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <cmath>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr double kMinQuaternionNorm = 1e-3;
constexpr double kMaxPosition = 1e7;  // m an axis: farther out, floats and tile indices give way

Vec3 readVec3(WireReader& in) {
  const double x = in.real(), y = in.real(), z = in.real();
  return {x, y, z};
}

Eigen::Quaterniond readOrientation(WireReader& in) {
  const double w = in.real(), x = in.real(), y = in.real(), z = in.real();
  const Eigen::Quaterniond q(w, x, y, z);
  const double norm = q.norm();
  in.check(std::isfinite(norm) && norm > kMinQuaternionNorm, "orientation is not finite or has no length");
  return in.failed() ? Eigen::Quaterniond::Identity() : q.normalized();
}

void storeOrientation(const Pose& pose, double* wxyz) {
  const Eigen::Quaterniond q(pose.linear());
  const double sign = q.w() < 0 ? -1 : 1;  // of the two quaternions of a rotation always the same one
  wxyz[0] = sign * q.w(), wxyz[1] = sign * q.x(), wxyz[2] = sign * q.y(), wxyz[3] = sign * q.z();
}

}  // namespace

Result<OdometrySample> decodePose(Bytes message) {
  WireReader in(message);
  in.fingerprint(bot_core::pose_t::getHash());
  OdometrySample sample;
  sample.utime_us = in.utime();
  sample.T_odom_body.translation() = readVec3(in);
  const Vec3& position = sample.T_odom_body.translation();
  in.check(position.allFinite(), "position is not finite");
  in.check(!(position.cwiseAbs().maxCoeff() > kMaxPosition), "position is out of bounds (more than 10,000 km away)");
  readVec3(in);  // vel
  sample.T_odom_body.linear() = readOrientation(in).toRotationMatrix();
  readVec3(in);  // rotation_rate
  readVec3(in);  // accel
  in.end();
  return in.failed() ? Result<OdometrySample>::fail(in.error()) : Result<OdometrySample>::ok(sample);
}

std::vector<std::uint8_t> encodePose(Micros utime_us, const Pose& T_parent_body) {
  bot_core::pose_t message{};
  message.utime = utime_us;
  store(T_parent_body.translation(), message.pos);
  storeOrientation(T_parent_body, message.orientation);
  return encode(message);
}

std::vector<std::uint8_t> encodePose(Micros utime_us, const Vec3& position, const Eigen::Quaterniond& orientation) {
  bot_core::pose_t message{};
  message.utime = utime_us;
  store(position, message.pos);
  message.orientation[0] = orientation.w(), message.orientation[1] = orientation.x();
  message.orientation[2] = orientation.y(), message.orientation[3] = orientation.z();
  return encode(message);
}

std::vector<std::uint8_t> encodeRigidTransform(Micros utime_us, const Pose& T_map_odom) {
  bot_core::rigid_transform_t message{};
  message.utime = utime_us;
  store(T_map_odom.translation(), message.trans);
  storeOrientation(T_map_odom, message.quat);
  return encode(message);
}

}  // namespace hgg
