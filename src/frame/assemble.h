#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "frame/frame.h"
#include "frame/odometry_buffer.h"

namespace hgg {

/// Pairs clouds with the odometry at their time. Knows no clock: arrival times and "now" are handed in, wall time of a
/// live bus or time of a log.
///
/// A cloud waits until odometry brackets its time, at most `odometry_wait_us` after its arrival. One that is not newer
/// than the cloud before it is dropped as invalid, unless time went back by more than kRestart_us (a restart of the
/// robot or its log): then mapping goes on in the new time. A single wrong time cannot deafen the assembler: only
/// frames that found their odometry, and clouds still waiting for it, count as "before".
class FrameAssembler {
 public:
  explicit FrameAssembler(Micros odometry_wait_us) : odometry_wait_us_(odometry_wait_us) {}

  void addOdometry(const OdometrySample& sample) { odometry_.add(sample); }
  void addCloud(SemanticCloud cloud, Micros arrival_us);

  /// The next frame whose odometry is known, in order of time; clouds that cannot get theirs any more are dropped on
  /// the way.
  std::optional<Frame> next(Micros now_us);
  /// Gives up on the clouds that still wait: no more odometry will come.
  void finish();

  bool isWaiting() const { return !waiting_.empty(); }
  const FrameDrops& drops() const { return drops_; }
  const OdometryBuffer& odometry() const { return odometry_; }
  /// How often time went back by more than kRestart_us between frames.
  std::int64_t restarts() const { return restarts_; }

 private:
  struct Waiting {
    SemanticCloud cloud;
    Micros arrival_us = 0;
  };

  Frame take(const Pose& T_odom_body);
  void dropOldest();
  bool hasWaitedEnough(Waiting& waiting, Micros now_us) const;

  Micros odometry_wait_us_;
  OdometryBuffer odometry_;
  std::deque<Waiting> waiting_;
  std::optional<Micros> last_frame_us_;
  FrameDrops drops_;
  std::int64_t restarts_ = 0;
};

}  // namespace hgg
