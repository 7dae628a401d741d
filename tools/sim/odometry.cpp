#include "sim/odometry.h"

#include <cmath>

namespace hgg {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Pose disturbStep(const Pose& step, const OdometryError& error, const RandomKey& key) {
  const double length = step.translation().norm(), root = std::sqrt(length);
  const double yaw = kDegree * (error.yaw_deg_per_m * length + error.yaw_noise_deg * root * gaussian(key, 3));
  Pose disturbed = step;
  disturbed.translation() *= 1.0 + error.scale;
  disturbed.translation() += error.noise * root * Vec3(gaussian(key, 0), gaussian(key, 1), gaussian(key, 2));
  disturbed.rotate(Eigen::AngleAxisd(yaw, Vec3::UnitZ()));
  return disturbed;
}

}  // namespace

OdometryError driftOf(double percent) {
  return {.scale = 0.01 * percent,
          .yaw_deg_per_m = 0.02 * percent,
          .noise = 0.002 * percent,
          .yaw_noise_deg = 0.02 * percent};
}

std::vector<Pose> disturbOdometry(const std::vector<Pose>& T_map_body, const OdometryError& error, std::uint64_t seed) {
  std::vector<Pose> odometry;
  for (std::size_t i = 0; i < T_map_body.size(); ++i) {
    odometry.push_back(i == 0 ? T_map_body[0]
                              : odometry[i - 1] *
                                    disturbStep(T_map_body[i - 1].inverse() * T_map_body[i], error, {seed, i}));
  }
  return odometry;
}

}  // namespace hgg
