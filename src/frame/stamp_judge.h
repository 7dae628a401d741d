#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/types.h"

namespace hgg {

/// Messages that are older than the newest by at most this are late, not a sign that the clock was set back.
constexpr Micros kLate_us = 1'000'000;
/// A stream that steps ahead by more than this has paused: what it counted from may have changed meanwhile.
constexpr Micros kPause_us = 10'000'000;

/// What to do with a message because of its stamp.
enum class StampVerdict : std::uint8_t {
  kNext,      // it goes on from the newest; one that is kept apart was an outlier
  kConfirms,  // the one that is kept apart was right, and this one goes on from it
  kApart,     // keep it apart until the following decide; one kept apart before was an outlier
  kLate,      // older than the newest, or as old: of no use
};

/// What a stream did between two stamps that are believed.
enum class StampStep : std::uint8_t { kSteady, kPaused, kWentBack };

/// Judges the stamps of one channel, so that a single wrong one cannot deafen it. A stamp that goes on from the newest,
/// at about the usual interval, is believed. Another one (far ahead, or back by more than kLate_us) is kept apart until
/// the next stamp: one that goes on from it confirms it (the stream paused, or its clock was set), one that goes on
/// from the newest or lies between the two makes it an outlier.
class StampJudge {
 public:
  StampVerdict judge(Micros utime_us);
  /// No more stamps will come: whether the one that is kept apart is to be believed. It is when it is ahead, since
  /// nothing spoke against it.
  bool believesTheLast();

  /// How the stream came to the one that was kept apart, once that is confirmed.
  StampStep step() const { return step_; }
  /// Median of the last intervals; 0 before there are three.
  Micros usualInterval_us() const;

 private:
  void goOnTo(Micros utime_us, Micros interval_us);
  bool goesOnFromApart(Micros utime_us) const;
  void confirm();
  Micros usualStep_us() const;

  std::optional<Micros> newest_us_, apart_us_;
  std::array<Micros, 9> intervals_us_{};  // the last ones, as a ring
  std::size_t intervals_ = 0;             // how many there have been
  StampStep step_ = StampStep::kSteady;
};

}  // namespace hgg
