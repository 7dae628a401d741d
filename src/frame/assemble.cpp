#include "frame/assemble.h"

#include <algorithm>
#include <utility>

namespace hgg {
namespace {

/// Bounds memory however long clouds wait: more than 10 s of them at 10 Hz, the widest gap that may be bridged.
constexpr std::size_t kMaxWaiting = 128;
/// So many samples after a cloud whose clock was set back the odometry would have followed it: StampJudge needs two.
constexpr std::int64_t kSamplesThatTell = 3;

constexpr float kLongestSweep = 0.5F;  // s of a scan: what says it took longer is waited for no longer

constexpr char kLate[] = "cloud: late or twice";
constexpr char kOutlier[] = "cloud: stamp out of line with those around it";
constexpr char kBegins[] = "odometry: begins after the cloud";
constexpr char kGap[] = "odometry: in a gap longer than frame.odometry_gap_s";
constexpr char kNoneInTime[] = "odometry: none came within frame.odometry_wait_ms";
constexpr char kNone[] = "odometry: there is none";
constexpr char kEnds[] = "odometry: ends before the cloud";
constexpr char kClockWentBack[] = "odometry: the clock was set back before it came";
constexpr char kClocksDiffer[] = "odometry: its clock was not set back with that of the clouds";
constexpr char kTooMany[] = "odometry: too many clouds waited for it";

Micros distance(Micros a, Micros b) { return a < b ? b - a : a - b; }

/// The time of a cloud's last point: odometry has to reach it, so that the cloud can be deskewed.
Micros latestOf(const SemanticCloud& cloud) {
  const auto last = std::ranges::max_element(cloud.times);
  const float after = last == cloud.times.end() ? 0.0F : std::clamp(*last, 0.0F, kLongestSweep);
  return cloud.utime_us + static_cast<Micros>(1e6F * after);
}

}  // namespace

void FrameAssembler::addOdometry(const OdometrySample& sample) {
  const auto before_us = odometry_.newest_us();
  odometry_.add(sample);
  const auto now_us = odometry_.newest_us();
  if (before_us && now_us && *now_us < *before_us) {
    dropAllOfTheTimeBefore(*before_us, *now_us);
  }
}

/// Clouds from before the clock was set back would find the pose of another moment once the new time is that far.
void FrameAssembler::dropAllOfTheTimeBefore(Micros before_us, Micros now_us) {
  const auto is_of_before = [&](const Waiting& w) {
    return distance(w.cloud.utime_us, before_us) < distance(w.cloud.utime_us, now_us);
  };
  for (auto n = std::erase_if(waiting_, is_of_before); n > 0; --n) {
    drop(kClockWentBack);
  }
}

void FrameAssembler::addCloud(SemanticCloud cloud, Micros arrival_us) {
  const StampVerdict verdict = cloud_stamps_.judge(cloud.utime_us);
  if (verdict == StampVerdict::kLate) {
    rejectCloud(kLate);
    return;
  }
  if (verdict == StampVerdict::kConfirms) {
    admitApart();
  }
  rejectApart();
  const Micros latest_us = latestOf(cloud);
  Waiting waiting{std::move(cloud), arrival_us, odometry_.believed(), latest_us};
  if (verdict == StampVerdict::kApart) {
    apart_ = std::move(waiting);
  } else {
    admit(std::move(waiting));
  }
}

void FrameAssembler::admit(Waiting waiting) {
  waiting_.push_back(std::move(waiting));
  if (waiting_.size() > kMaxWaiting) {
    dropOldest(kTooMany);
  }
}

void FrameAssembler::admitApart() {
  if (cloud_stamps_.step() == StampStep::kWentBack) {
    while (!waiting_.empty()) {
      dropOldest(kClockWentBack);
    }
  }
  admit(std::move(*apart_));
  apart_.reset();
}

void FrameAssembler::rejectApart() {
  if (apart_) {
    rejectCloud(kOutlier);
    apart_.reset();
  }
}

void FrameAssembler::finish() {
  odometry_.finish();
  if (cloud_stamps_.believesTheLast()) {
    admitApart();
  }
  rejectApart();
  finished_ = true;
}

std::optional<Frame> FrameAssembler::next(Micros now_us) {
  while (!waiting_.empty()) {
    Waiting& front = waiting_.front();
    const auto pose = odometry_.at(odometryTimeOf(front.cloud.utime_us));
    if (pose && !isAloneBack(front.cloud.utime_us)) {
      const bool reaches = odometry_.missAt(front.latest_us + delay_us_) != OdometryMiss::kAhead;
      if (reaches || front.latest_us == front.cloud.utime_us || finished_ || hasWaitedEnough(front, now_us)) {
        return take(*pose);
      }
      return std::nullopt;
    }
    if (mayStillCome(front, now_us)) {
      return std::nullopt;
    }
    longest_gap_us_ = std::max(longest_gap_us_, pose ? 0 : odometry_.gapAround_us(front.cloud.utime_us + delay_us_));
    dropOldest(whyNone(front));
  }
  return std::nullopt;
}

/// The stamp of the odometry sample that belongs to a cloud. At the end of the messages the last one has to do where a
/// delay asks for a later one.
Micros FrameAssembler::odometryTimeOf(Micros utime_us) const {
  const auto newest_us = odometry_.newest_us();
  const Micros belongs_us = utime_us + delay_us_;
  return finished_ && newest_us && utime_us <= *newest_us ? std::min(belongs_us, *newest_us) : belongs_us;
}

/// Whether the clouds' clock was set back and the odometry's was not, or not yet: its poses of this time are those of
/// the first time round.
bool FrameAssembler::isAloneBack(Micros utime_us) const {
  return isBack(utime_us) && odometry_.counts().anew == last_stretch_;
}

bool FrameAssembler::mayStillCome(Waiting& waiting, Micros now_us) const {
  if (finished_ || hasWaitedEnough(waiting, now_us)) {
    return false;
  }
  return odometry_.missAt(waiting.cloud.utime_us + delay_us_) == OdometryMiss::kAhead ||
         (isAloneBack(waiting.cloud.utime_us) && odometry_.believed() - waiting.odometry_then < kSamplesThatTell);
}

const char* FrameAssembler::whyNone(const Waiting& waiting) const {
  const Micros utime_us = waiting.cloud.utime_us;
  const OdometryMiss miss = odometry_.missAt(utime_us + delay_us_);
  if (miss != OdometryMiss::kAhead && isAloneBack(utime_us)) {
    return kClocksDiffer;
  }
  if (miss == OdometryMiss::kAhead) {
    return !finished_ ? kNoneInTime : odometry_.size() == 0 ? kNone : kEnds;
  }
  return miss == OdometryMiss::kBefore ? kBegins : kGap;
}

Frame FrameAssembler::take(const OdometryPose& pose) {
  SemanticCloud cloud = std::move(waiting_.front().cloud);
  waiting_.pop_front();
  restarts_ += isBack(cloud.utime_us) ? 1 : 0;
  const bool anew = last_frame_us_ && (pose.stretch != last_stretch_ ||
                                       odometry_.fellSilent(*last_frame_us_ + delay_us_, cloud.utime_us + delay_us_));
  Frame frame{cloud.utime_us,      pose.T_odom_body, std::move(cloud.points), anew,
              cloud.p_body_sensor, std::nullopt,     std::move(cloud.times)};
  if (last_frame_us_ && delay_us_ != last_delay_us_) {
    const auto before = odometry_.at(*last_frame_us_ + delay_us_);
    frame.T_odom_before = before ? std::optional(before->T_odom_body) : std::nullopt;
  }
  last_delay_us_ = delay_us_;
  last_frame_us_ = cloud.utime_us;
  last_stretch_ = pose.stretch;
  return frame;
}

void FrameAssembler::drop(const char* cause) {
  ++drops_.odometry;
  ++drops_.causes[cause];
}

void FrameAssembler::dropOldest(const char* cause) {
  waiting_.pop_front();
  drop(cause);
}

void FrameAssembler::rejectCloud(const char* cause) {
  ++drops_.invalid;
  ++drops_.causes[cause];
}

bool FrameAssembler::hasWaitedEnough(Waiting& waiting, Micros now_us) const {
  waiting.arrival_us = std::min(waiting.arrival_us, now_us);  // a log whose clock went back must not wait for ever
  return limits_.wait_us && now_us - waiting.arrival_us > *limits_.wait_us;
}

}  // namespace hgg
