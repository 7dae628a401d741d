#include "alignment/prediction.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace hgg {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Standard deviations of a pose that is known: small, and still invertible.
constexpr double kKnown = 1e-4;  // m and rad

/// How a small change (v, w) of the last pose moves the next one.
Mat6 transport(const Vec3& way_map) {
  Mat6 F = Mat6::Identity();
  F.topRightCorner<3, 3>() << 0, way_map.z(), -way_map.y(), -way_map.z(), 0, way_map.x(), way_map.y(), -way_map.x(), 0;
  return F;
}

}  // namespace

PoseBelief predictPose(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config) {
  const double way = T_last_body.translation().norm();
  const double turn = Eigen::AngleAxisd(T_last_body.linear()).angle();
  const double drift = config.odometry_drift * way + config.odometry_jitter;
  const double twist =
      kDegree * (config.odometry_turn_deg * way + config.odometry_jitter_deg) + config.odometry_drift * turn;
  const Mat6 F = transport(last.T_map_body.linear() * T_last_body.translation());
  Mat6 cov = F * last.information.inverse() * F.transpose();
  cov.diagonal().head<3>().array() += drift * drift;
  cov.diagonal().tail<3>().array() += twist * twist;
  PoseBelief next;
  next.T_map_body = last.T_map_body * T_last_body;
  next.information = cov.inverse();
  next.information = 0.5 * (next.information + next.information.transpose()).eval();
  return next;
}

PoseBelief startPose(const Pose& T_map_body) { return {T_map_body, Mat6::Identity() / (kKnown * kKnown)}; }

}  // namespace hgg
