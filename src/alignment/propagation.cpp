#include "alignment/propagation.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

// All of these were chosen by hand; docs/method.md, "Pose propagation", says what for.
/// Standard deviations of a pose that is known: far below what alignment can tell, and still invertible.
constexpr double kKnown = 1e-4, kKnownTurn = 1e-5;  // m, rad
/// Standard deviations of a pose in a stored map whose place the user gave.
constexpr double kResumed = 0.3, kResumedTurn = 3 * kDegree;  // m, rad
/// The largest motion of a robot between two frames.
constexpr double kLongestWay = 30, kWidestTurn = 120 * kDegree;  // m, rad
/// Motions from which on odometry's jitter counts in full; at rest it has none.
constexpr double kFullMotion = 0.05, kFullTurn = kDegree;  // m, rad

}  // namespace

MotionNoise odometryNoise(const Pose& T_last_body, const AlignmentConfig& config) {
  const double way = T_last_body.translation().norm();
  const double turn = turnOf(T_last_body);
  const double moving = std::min(1.0, way / kFullMotion + turn / kFullTurn);
  return {config.odometry_drift * way + config.odometry_jitter * moving + kKnown,
          kDegree * (config.odometry_turn_deg * way + config.odometry_jitter_deg * moving) +
              config.odometry_drift * turn + kKnownTurn};
}

bool isPossibleMotion(const Pose& T_last_body) {
  return T_last_body.translation().norm() <= kLongestWay && turnOf(T_last_body) <= kWidestTurn;
}

std::optional<PoseBelief> propagatePose(const PoseBelief& last, const Pose& T_last_body, const MotionNoise& noise) {
  if (!isPossibleMotion(T_last_body)) {
    return std::nullopt;
  }
  const Mat6 F = tangentTransport(last.T_map_body.linear() * T_last_body.translation());
  Mat6 cov = F * last.information.inverse() * F.transpose();
  cov.diagonal().head<3>().array() += noise.position * noise.position;
  cov.diagonal().tail<3>().array() += noise.turn * noise.turn;
  const Eigen::LLT<Mat6> factor(0.5 * (cov + cov.transpose()));
  if (factor.info() != Eigen::Success) {
    return std::nullopt;
  }
  const Mat6 information = factor.solve(Mat6::Identity());
  return PoseBelief{orthonormalized(last.T_map_body * T_last_body), 0.5 * (information + information.transpose())};
}

PoseBelief startPose(const Pose& T_map_body, bool gauge) {
  Vec6 deviations;
  deviations << Vec3::Constant(gauge ? kKnown : kResumed), Vec3::Constant(gauge ? kKnownTurn : kResumedTurn);
  return {T_map_body, deviations.cwiseAbs2().cwiseInverse().asDiagonal()};
}

}  // namespace hgg
