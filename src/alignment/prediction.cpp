#include "alignment/prediction.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "core/so3.h"

namespace hgg {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// Standard deviations of a pose that is known: small, and still invertible.
constexpr double kKnown = 1e-4, kKnownTurn = 1e-5;               // m, rad
constexpr double kLongestWay = 30, kWidestTurn = 120 * kDegree;  // m, rad, between two frames
/// Motions from which on odometry's jitter counts in full; at rest it has none.
constexpr double kFullMotion = 0.05, kFullTurn = kDegree;  // m, rad

/// How a small change (v, w) of the last pose moves the next one.
Mat6 transport(const Vec3& way_map) {
  Mat6 F = Mat6::Identity();
  F.topRightCorner<3, 3>() << 0, way_map.z(), -way_map.y(), -way_map.z(), 0, way_map.x(), way_map.y(), -way_map.x(), 0;
  return F;
}

}  // namespace

std::optional<PoseBelief> predictPose(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config) {
  const double way = T_last_body.translation().norm();
  const double turn = Eigen::AngleAxisd(T_last_body.linear()).angle();
  if (!(way <= kLongestWay && turn <= kWidestTurn)) {
    return std::nullopt;
  }
  const double moving = std::min(1.0, way / kFullMotion + turn / kFullTurn);
  const double drift = config.odometry_drift * way + config.odometry_jitter * moving + kKnown;
  const double twist = kDegree * (config.odometry_turn_deg * way + config.odometry_jitter_deg * moving) +
                       config.odometry_drift * turn + kKnownTurn;
  const Mat6 F = transport(last.T_map_body.linear() * T_last_body.translation());
  Mat6 cov = F * last.information.inverse() * F.transpose();
  cov.diagonal().head<3>().array() += drift * drift;
  cov.diagonal().tail<3>().array() += twist * twist;
  const Eigen::LLT<Mat6> factor(0.5 * (cov + cov.transpose()));
  if (factor.info() != Eigen::Success) {
    return std::nullopt;
  }
  const Mat6 information = factor.solve(Mat6::Identity());
  return PoseBelief{orthonormalized(last.T_map_body * T_last_body), 0.5 * (information + information.transpose())};
}

PoseBelief startPose(const Pose& T_map_body, bool gauge) {
  Vec6 deviations;
  deviations << Vec3::Constant(gauge ? kKnown : 0.3), Vec3::Constant(gauge ? kKnownTurn : 3 * kDegree);
  return {T_map_body, deviations.cwiseAbs2().cwiseInverse().asDiagonal()};
}

}  // namespace hgg
