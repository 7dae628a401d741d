#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/codec.h"
#include "config.h"
#include "core/types.h"
#include "stats.h"

namespace hgg {

/// Units that are taken for microseconds by mistake: seconds, milliseconds, nanoseconds.
inline constexpr std::size_t kTimeUnits = 3;

/// Enough of the last stamps that a few wrong ones do not count.
inline constexpr std::size_t kRecentStamps = 33;

/// What came on one channel. Stamps are those of poses, clouds and images, as they are in the messages.
struct ChannelInput {
  std::int64_t messages = 0;
  std::int64_t poses = 0, clouds = 0, images = 0;
  Micros first_arrival_us = 0, last_arrival_us = 0;
  std::int64_t stamps = 0;
  Micros lowest_stamp_us = 0, highest_stamp_us = 0;
  std::array<Micros, kRecentStamps>
      ahead_us{};  // of the last stamps: by how much they were ahead of arrival, as a ring
  Micros measured_from_us = 0, stamp_then_us = 0;            // arrival and stamp where the present stretch began
  std::int64_t stretches = 0;                                // over which the rate of the stamps was measured
  std::array<std::int64_t, kTimeUnits> stretches_in_unit{};  // of those, where it was that of another unit
};

/// Watches the channels of a log or a live bus, so that a run that maps nothing can say why.
class InputWatch {
 public:
  /// `arrival_us`: of the log or of the receiver's clock.
  void add(const std::string& channel, Micros arrival_us, Bytes message);

  /// What is wrong with the stamps of the cloud and the odometry channel such that no map should be made of them: all
  /// the same, or not microseconds. A line each.
  std::vector<std::string> faults(const LcmConfig& lcm) const;
  /// What else looks odd: the clocks of the two channels differ. A line each.
  std::vector<std::string> oddities(const LcmConfig& lcm) const;
  /// One line on why there is no frame: channels that are silent, what there is instead, stamps that do not fit, and
  /// what `counts` says became of the messages.
  std::string explainNoFrames(const LcmConfig& lcm, const RunCounts& counts) const;
  bool isEmpty() const { return channels_.empty(); }

 private:
  const ChannelInput* find(const std::string& channel) const;
  std::string listChannels() const;

  std::map<std::string, ChannelInput> channels_;
};

}  // namespace hgg
