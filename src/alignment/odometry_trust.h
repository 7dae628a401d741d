#pragma once

#include <array>

#include "config.h"
#include "core/se3.h"

namespace hgg {

/// Factors on the standard deviations that the config gives odometry.
struct NoiseScale {
  double position = 1, turn = 1;
};

/// How much odometry is believed, learned from what alignment makes of it. The config's noise is only where it starts:
/// the factor on it follows the innovations, quickly upwards and slowly downwards, and never below one. Straight motion
/// and turns have factors of their own, because a delay or a bad gyroscope shows in turns only.
///
/// Beside odometry stands a second prediction that needs no sensor: the robot goes on as it did between the last two
/// frames. It takes over while odometry's errors are many times as large as its own: a wheel that slips, a driver that
/// repeats its last pose, axes in the wrong order.
class OdometryTrust {
 public:
  /// After a frame that the map has aligned: the motion since the frame before it as odometry has it, as it would be at
  /// constant velocity, and as alignment found it.
  void learn(const Pose& T_by_odometry, const Pose& T_by_velocity, const Pose& T_aligned,
             const AlignmentConfig& config);

  NoiseScale noiseOf(const Pose& T_last_body) const;
  /// False while constant velocity predicts better.
  bool isBelieved() const { return is_believed_; }
  /// Root of the mean square of the last errors of constant velocity, in standard deviations of the config's odometry.
  NoiseScale velocityErrors() const;

 private:
  struct MeanSquares {
    double position = 0, turn = 0;
  };

  std::array<MeanSquares, 2> scale_ = {MeanSquares{1, 1}, MeanSquares{1, 1}};  // straight, turning: squared factors
  MeanSquares odometry_, velocity_;  // errors of late, as shares of what the config expects
  bool is_believed_ = true;
};

/// The config with odometry's noise multiplied.
AlignmentConfig scaled(AlignmentConfig config, const NoiseScale& scale);

}  // namespace hgg
