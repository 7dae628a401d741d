#include "frame/stamp_judge.h"

#include <algorithm>

namespace hgg {
namespace {

constexpr std::size_t kEnoughIntervals = 3;     // for a median that one odd interval does not decide
constexpr Micros kUsualIntervals = 3;           // a step of so many usual intervals is nothing to wonder about
constexpr Micros kSmallStep_us = 100'000;       // nor is one of this length
constexpr Micros kUnknownStep_us = 1'000'000;   // the same while the usual interval is not known
constexpr Micros kGoesOnWithin_us = kPause_us;  // after a step back, the next stamp must follow within this

}  // namespace

StampVerdict StampJudge::judge(Micros utime_us) {
  if (!newest_us_) {
    newest_us_ = utime_us;
    return StampVerdict::kNext;
  }
  const Micros step_us = utime_us - *newest_us_;
  if (step_us > 0 && step_us <= usualStep_us()) {
    goOnTo(utime_us, step_us);
    return StampVerdict::kNext;
  }
  if (goesOnFromApart(utime_us)) {
    const Micros interval_us = utime_us - *apart_us_;
    confirm();
    goOnTo(utime_us, interval_us);
    return StampVerdict::kConfirms;
  }
  if (step_us <= 0 && step_us >= -kLate_us) {
    return StampVerdict::kLate;
  }
  apart_us_ = utime_us;
  return StampVerdict::kApart;
}

bool StampJudge::believesTheLast() {
  if (!apart_us_ || *apart_us_ < *newest_us_) {
    return false;
  }
  confirm();
  return true;
}

void StampJudge::goOnTo(Micros utime_us, Micros interval_us) {
  intervals_us_[intervals_++ % intervals_us_.size()] = interval_us;
  newest_us_ = utime_us;
  apart_us_.reset();
}

/// Ahead, any later stamp speaks for the one kept apart: had that been an outlier, the next would lie before it. Back
/// in time it must also come soon, so that two wrong stamps do not make a clock that was set.
bool StampJudge::goesOnFromApart(Micros utime_us) const {
  if (!apart_us_ || utime_us <= *apart_us_) {
    return false;
  }
  const Micros back_us = *newest_us_ - *apart_us_;
  return back_us < 0 || utime_us - *apart_us_ <= std::max(usualStep_us(), std::min(back_us, kGoesOnWithin_us));
}

void StampJudge::confirm() {
  const Micros step_us = *apart_us_ - *newest_us_;
  step_ = step_us < 0 ? StampStep::kWentBack : step_us > kPause_us ? StampStep::kPaused : StampStep::kSteady;
  newest_us_ = apart_us_;
  apart_us_.reset();
}

Micros StampJudge::usualInterval_us() const {
  if (intervals_ < kEnoughIntervals) {
    return 0;
  }
  auto sorted = intervals_us_;
  auto* const end = sorted.data() + std::min(intervals_, sorted.size());
  auto* const middle = sorted.data() + (end - sorted.data()) / 2;
  std::nth_element(sorted.data(), middle, end);
  return *middle;
}

Micros StampJudge::usualStep_us() const {
  const Micros usual_us = usualInterval_us();
  return usual_us == 0 ? kUnknownStep_us : std::max(kSmallStep_us, kUsualIntervals * usual_us);
}

}  // namespace hgg
