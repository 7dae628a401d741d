#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "frame/odometry_buffer.h"

namespace hgg {

/// Estimates by how much odometry's stamps lag behind those of the clouds: a sample stamped t tells where the body was
/// at t - delay, so that the pose of a cloud is that of the sample stamped delay later. An unsynchronised clock does
/// that, or a driver that stamps on arrival.
///
/// Alignment knows how the body turned from frame to frame. Over windows of a second, its turn is held against the turn
/// that odometry shows at every delay from -0.5 to 0.5 s; the delay with the least squared difference wins. Straight
/// driving says nothing; only a change of the turn rate does.
class OdometryDelay {
 public:
  /// From an earlier session on the same robot; turns that show another delay replace it.
  void startFrom(Micros delay_us) { applied_us_ = delay_us; }
  /// Steps of odometry reach `odometry` later than their frames: they are compared when it is far enough.
  void add(Micros utime_us, const std::optional<Mat3>& R_last_body);
  void compare(const OdometryBuffer& odometry);

  /// The delay that frames should be paired with, us. 0 until the turns have shown another one for certain: to 10 ms,
  /// and clearly better than the present one.
  Micros applied_us() const { return applied_us_; }
  /// The estimate itself, s, and its standard deviation; nullopt while turns have not told.
  struct Estimate {
    double delay = 0, sigma = 0;
  };
  std::optional<Estimate> estimate() const;

 private:
  /// The attitude of a frame in a frame of reference that stays while alignment is not interrupted.
  struct Attitude {
    Micros utime_us = 0;
    Mat3 R = Mat3::Identity();
  };
  /// The turn of the body over a window, not compared yet.
  struct Turn {
    Micros from_us = 0, to_us = 0;
    Vec3 turn = Vec3::Zero();
  };

  void compare(const Turn& turn, const OdometryBuffer& odometry);
  void decide();

  std::deque<Attitude> window_;
  std::deque<Turn> waiting_;
  std::vector<double> squares_;  // summed squared differences, rad^2, by candidate delay
  double count_ = 0;             // windows in them
  double per_window_ = 1;        // frames in a window, about: as often is each frame's turn counted
  Micros interval_us_ = 0;       // usual time between odometry's samples
  Micros applied_us_ = 0;
};

}  // namespace hgg
