#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "frame/frame.h"

namespace hgg {

/// A clock that goes back by more than this is a restart of the robot or of its log; by less, a late message.
constexpr Micros kRestart_us = 10'000'000;
/// Between samples further apart than this the motion is anyone's guess.
constexpr Micros kMaxOdometryGap_us = 1'000'000;

/// The odometry of the recent past, in ascending time; when full, the oldest sample goes.
class OdometryBuffer {
 public:
  explicit OdometryBuffer(std::size_t capacity = 8192) : capacity_(capacity) {}

  /// Samples that are not newer than the newest are rejected, unless time went back by more than kRestart_us: then
  /// everything from before is forgotten. Returns whether the sample was taken.
  bool add(const OdometrySample& sample);

  /// T_odom_body at `utime_us`: the sample itself where one has that time, else interpolated between its two neighbours
  /// (linear, slerp). nullopt outside the samples and in gaps longer than kMaxOdometryGap_us.
  std::optional<Pose> at(Micros utime_us) const;
  /// Whether samples still to come may give a pose for `utime_us`.
  bool isAhead(Micros utime_us) const { return samples_.empty() || utime_us > samples_.back().utime_us; }

  std::size_t size() const { return samples_.size(); }
  std::int64_t rejected() const { return rejected_; }

 private:
  std::size_t capacity_;
  std::deque<OdometrySample> samples_;
  std::int64_t rejected_ = 0;
};

/// The pose a share `s` (0..1) of the way from a to b: translation linear, rotation on the shorter great arc.
Pose interpolate(const Pose& a, const Pose& b, double s);

}  // namespace hgg
