#include "alignment/odometry_trust.h"

#include <algorithm>
#include <cmath>

#include "alignment/propagation.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr double kTurning = 1 * kDegree;  // rad between two frames, from which on a motion is a turn
/// Shares of a new innovation in the mean: one that is many times what was expected counts at once.
constexpr double kRise = 0.5, kFall = 0.02, kSurprise = 4;
constexpr double kLargestScale = 30;  // on a standard deviation: keeps one absurd sample from deciding for long
/// Errors of late are means over about five frames.
constexpr double kLately = 0.2;
/// Odometry is no longer believed when its squared errors are this many times those of constant velocity and of what
/// the config allows it, and is believed again when they are less than those of constant velocity.
constexpr double kManyTimes = 9;

void follow(double& mean, double squared_ratio) {
  const double share = squared_ratio > kSurprise * mean ? kRise : kFall;
  mean = std::clamp(mean + share * (squared_ratio - mean), 1.0, square(kLargestScale));
}

}  // namespace

void OdometryTrust::learn(const Pose& T_by_odometry, const Pose& T_by_velocity, const Pose& T_aligned,
                          const AlignmentConfig& config) {
  const Pose off = T_by_odometry.inverse() * T_aligned, off_velocity = T_by_velocity.inverse() * T_aligned;
  const MotionNoise expected = odometryNoise(T_by_odometry, config);
  const double position = square(off.translation().norm()), turn = square(turnOf(off));
  // At rest odometry is expected to be exact, which alignment is not.
  const double allowed = 3 * square(std::max(expected.position, config.odometry_jitter));
  const double allowed_turn = 3 * square(std::max(expected.turn, kDegree * config.odometry_jitter_deg));
  MeanSquares& scale = scale_[turnOf(T_aligned) > kTurning ? 1 : 0];
  follow(scale.position, position / allowed);
  follow(scale.turn, turn / allowed_turn);
  const auto blend = [](double& mean, double ratio) { mean += kLately * (ratio - mean); };
  blend(odometry_.position, position / allowed), blend(odometry_.turn, turn / allowed_turn);
  blend(velocity_.position, square(off_velocity.translation().norm()) / allowed);
  blend(velocity_.turn, square(turnOf(off_velocity)) / allowed_turn);
  const double of_odometry = odometry_.position + odometry_.turn, of_velocity = velocity_.position + velocity_.turn;
  is_believed_ = is_believed_ ? of_odometry < kManyTimes * std::max(of_velocity, 1.0) : of_odometry < of_velocity;
}

NoiseScale OdometryTrust::noiseOf(const Pose& T_last_body) const {
  const MeanSquares& scale = scale_[turnOf(T_last_body) > kTurning ? 1 : 0];
  return {std::sqrt(scale.position), std::sqrt(scale.turn)};
}

NoiseScale OdometryTrust::velocityErrors() const { return {std::sqrt(velocity_.position), std::sqrt(velocity_.turn)}; }

AlignmentConfig scaled(AlignmentConfig config, const NoiseScale& scale) {
  config.odometry_drift *= std::max(scale.position, scale.turn);
  config.odometry_jitter *= scale.position;
  config.odometry_turn_deg *= scale.turn;
  config.odometry_jitter_deg *= scale.turn;
  return config;
}

}  // namespace hgg
