#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "frame/stamp_judge.h"

namespace hgg {

/// The messages of a sensor from the recent past, in order of time, from which the one nearest to a moment is taken.
/// Stamps are judged by StampJudge; one that stood apart costs its message. When full, the oldest goes.
template <typename T>
class Stream {
 public:
  struct Entry {
    Micros utime_us = 0;
    T value;
  };

  /// False when the stamp makes it useless.
  bool add(Micros utime_us, T value, Micros arrival_us) {
    ++received_;
    last_arrival_us_ = arrival_us;
    const StampVerdict verdict = judge_.judge(utime_us);
    if (verdict == StampVerdict::kLate || verdict == StampVerdict::kApart) {
      return false;
    }
    if (verdict == StampVerdict::kConfirms && judge_.step() == StampStep::kWentBack) {
      entries_.clear();
    }
    entries_.push_back({utime_us, std::move(value)});
    if (entries_.size() > kMost) {
      entries_.pop_front();
    }
    return true;
  }

  const Entry* nearest(Micros utime_us) const {
    const Entry* best = nullptr;
    for (const Entry& entry : entries_) {
      if (best == nullptr || distance(entry.utime_us, utime_us) < distance(best->utime_us, utime_us)) {
        best = &entry;
      }
    }
    return best;
  }

  /// Whether none that still comes can be nearer to `utime_us`, going by the usual interval.
  bool isSettled(Micros utime_us) const {
    const Entry* best = nearest(utime_us);
    return best != nullptr && (entries_.back().utime_us >= utime_us ||
                               2 * distance(best->utime_us, utime_us) <= judge_.usualInterval_us());
  }

  /// Whether it has been silent for so long that nobody should wait for it.
  bool isSilent(Micros now_us) const {
    constexpr Micros kSilence_us = 1'000'000, kSilentIntervals = 5;
    return last_arrival_us_ && now_us - *last_arrival_us_ > std::max(kSilence_us, kSilentIntervals * usual_us());
  }

  Micros usual_us() const { return judge_.usualInterval_us(); }
  std::int64_t received() const { return received_; }

  static Micros distance(Micros a, Micros b) { return a < b ? b - a : a - b; }

 private:
  static constexpr std::size_t kMost = 32;  // messages: a second of 30 Hz

  StampJudge judge_;
  std::deque<Entry> entries_;
  std::optional<Micros> last_arrival_us_;
  std::int64_t received_ = 0;
};

}  // namespace hgg
