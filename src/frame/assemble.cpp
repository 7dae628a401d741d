#include "frame/assemble.h"

#include <algorithm>
#include <utility>

namespace hgg {
namespace {

constexpr std::size_t kMaxWaiting = 64;  // clouds; bounds memory whatever the configured wait

}  // namespace

void FrameAssembler::addCloud(SemanticCloud cloud, Micros arrival_us) {
  const auto before_us = waiting_.empty() ? last_frame_us_ : waiting_.back().cloud.utime_us;
  if (before_us && cloud.utime_us <= *before_us) {
    if (*before_us - cloud.utime_us <= kRestart_us) {
      ++drops_.invalid;
      return;
    }
    finish();  // their odometry belongs to the time before the restart
  }
  waiting_.push_back({std::move(cloud), arrival_us});
  if (waiting_.size() > kMaxWaiting) {
    dropOldest();
  }
}

std::optional<Frame> FrameAssembler::next(Micros now_us) {
  while (!waiting_.empty()) {
    const Micros utime_us = waiting_.front().cloud.utime_us;
    if (const auto T_odom_body = odometry_.at(utime_us)) {
      return take(*T_odom_body);
    }
    if (odometry_.isAhead(utime_us) && !hasWaitedEnough(waiting_.front(), now_us)) {
      return std::nullopt;
    }
    dropOldest();
  }
  return std::nullopt;
}

void FrameAssembler::finish() {
  while (!waiting_.empty()) {
    dropOldest();
  }
}

Frame FrameAssembler::take(const Pose& T_odom_body) {
  SemanticCloud cloud = std::move(waiting_.front().cloud);
  waiting_.pop_front();
  if (last_frame_us_ && cloud.utime_us < *last_frame_us_) {
    ++restarts_;
  }
  last_frame_us_ = cloud.utime_us;
  return {cloud.utime_us, T_odom_body, std::move(cloud.points)};
}

void FrameAssembler::dropOldest() {
  waiting_.pop_front();
  ++drops_.odometry;
}

bool FrameAssembler::hasWaitedEnough(Waiting& waiting, Micros now_us) const {
  waiting.arrival_us = std::min(waiting.arrival_us, now_us);  // a log whose clock went back must not wait for ever
  return now_us - waiting.arrival_us > odometry_wait_us_;
}

}  // namespace hgg
