#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "frame/frame.h"
#include "frame/odometry_buffer.h"

namespace hgg {

/// How long a cloud waits for odometry, and what is interpolated.
struct PairingLimits {
  std::optional<Micros> wait_us;  // after a cloud's arrival; unset: as long as messages come
  Micros max_gap_us = 3'000'000;  // between two samples of odometry
};

/// Pairs clouds with the odometry at their time. Knows no clock: arrival times and "now" are handed in, wall time of a
/// live bus or time of a log.
///
/// A cloud waits until odometry brackets its time, at most `wait_us` after its arrival. One that is not newer than the
/// cloud before it is dropped as invalid, unless the clock was set back (see StampJudge): then mapping goes on in the
/// new time, once the odometry is there too. A single wrong stamp cannot deafen the assembler.
class FrameAssembler {
 public:
  explicit FrameAssembler(const PairingLimits& limits) : limits_(limits), odometry_(limits.max_gap_us) {}

  void addOdometry(const OdometrySample& sample);
  void addCloud(SemanticCloud cloud, Micros arrival_us);
  /// From the next frame on, the pose of a cloud is that of the odometry sample stamped this much later
  /// (OdometryDelay).
  void setDelay(Micros delay_us) { delay_us_ = delay_us; }
  /// No more messages will come: what they would have decided is decided, and clouds that wait no longer do. The last
  /// frames are then taken with next().
  void finish();

  /// The next frame whose odometry is known, in order of time; clouds that cannot get theirs any more are dropped on
  /// the way.
  std::optional<Frame> next(Micros now_us);

  bool isWaiting() const { return !waiting_.empty(); }
  const FrameDrops& drops() const { return drops_; }
  const OdometryBuffer& odometry() const { return odometry_; }
  /// How often time went back between frames.
  std::int64_t restarts() const { return restarts_; }
  /// The longest gap of odometry that cost a cloud; 0: none did.
  Micros longestGap_us() const { return longest_gap_us_; }

 private:
  struct Waiting {
    SemanticCloud cloud;
    Micros arrival_us = 0;
    std::int64_t odometry_then = 0;  // samples that were believed when it came
    Micros latest_us = 0;            // time of its last point
  };

  void admit(Waiting waiting);
  void admitApart();
  void rejectApart();
  void dropAllOfTheTimeBefore(Micros before_us, Micros now_us);
  Frame take(const OdometryPose& pose);
  Micros odometryTimeOf(Micros utime_us) const;
  bool isBack(Micros utime_us) const { return last_frame_us_ && utime_us <= *last_frame_us_; }
  bool isAloneBack(Micros utime_us) const;
  bool mayStillCome(Waiting& waiting, Micros now_us) const;
  bool hasWaitedEnough(Waiting& waiting, Micros now_us) const;
  const char* whyNone(const Waiting& waiting) const;
  void drop(const char* cause);
  void dropOldest(const char* cause);
  void rejectCloud(const char* cause);

  PairingLimits limits_;
  OdometryBuffer odometry_;
  StampJudge cloud_stamps_;
  std::optional<Waiting> apart_;
  std::deque<Waiting> waiting_;
  std::optional<Micros> last_frame_us_;
  std::int64_t last_stretch_ = 0;
  Micros delay_us_ = 0, last_delay_us_ = 0;  // of the next frame, of the one before
  bool finished_ = false;
  FrameDrops drops_;
  std::int64_t restarts_ = 0;
  Micros longest_gap_us_ = 0;
};

}  // namespace hgg
