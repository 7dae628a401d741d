#include "inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace hgg {
namespace {

constexpr std::int64_t kEnoughStamps = 5;     // to say that they are all the same
constexpr Micros kStretch_us = 1'500'000;     // of arrivals, over which the rate of stamps is measured
constexpr std::int64_t kEnoughStretches = 2;  // one wrong stamp at the end of a stretch is no other unit
constexpr double kRateTolerance = 2;          // factor
constexpr double kClocksDiffer_us = 1e6;      // latency explains less
constexpr double kFarthest_us = 4e18;         // less than an int64_t holds
constexpr std::size_t kMostListed = 40;       // channels
constexpr Micros kApart_us = 10'000'000;      // between the stamps of two channels that never meet

struct Unit {
  double per_us;
  const char* name;
};
constexpr std::array<Unit, kTimeUnits> kUnits = {Unit{1e-6, "seconds"}, Unit{1e-3, "milliseconds"},
                                                 Unit{1e3, "nanoseconds"}};

/// "41.7 years", "37.0 s".
std::string timeText(double us) {
  const double s = std::abs(us) * 1e-6;
  constexpr double kDay = 86400, kYear = 365.25 * kDay;
  return s >= kYear  ? fmt::format("{:.1f} years", s / kYear)
         : s >= kDay ? fmt::format("{:.1f} days", s / kDay)
                     : fmt::format("{:.{}f} s", s, s < 100 ? 1 : 0);
}

/// a - b for any two stamps, whatever a message or a log says.
Micros difference(Micros a, Micros b) {
  const double d = static_cast<double>(a) - static_cast<double>(b);
  return std::abs(d) < kFarthest_us ? a - b : static_cast<Micros>(std::copysign(kFarthest_us, d));
}

/// Measures how fast stamps go, stretch by stretch, so that a few wrong ones do not spoil it.
void measureRate(ChannelInput& c, Micros arrival_us, Micros stamp_us) {
  const Micros passed_us = difference(arrival_us, c.measured_from_us);
  if (c.stamps > 0 && passed_us >= 0 && passed_us < kStretch_us) {
    return;
  }
  if (c.stamps > 0 && passed_us > 0) {
    const double rate =
        (static_cast<double>(stamp_us) - static_cast<double>(c.stamp_then_us)) / static_cast<double>(passed_us);
    ++c.stretches;
    for (std::size_t u = 0; u < kTimeUnits; ++u) {
      c.stretches_in_unit[u] +=
          rate > kUnits[u].per_us / kRateTolerance && rate < kUnits[u].per_us * kRateTolerance ? 1 : 0;
    }
  }
  c.measured_from_us = arrival_us;
  c.stamp_then_us = stamp_us;
}

/// What unit the stamps have, nullptr: microseconds, or it cannot be said.
const char* wrongUnit(const ChannelInput& c) {
  for (std::size_t u = 0; u < kTimeUnits; ++u) {
    if (c.stretches >= kEnoughStretches && 2 * c.stretches_in_unit[u] > c.stretches) {
      return kUnits[u].name;
    }
  }
  return nullptr;
}

/// Median over the last stamps; the difference of two channels is that of their clocks.
double aheadOfArrival_us(const ChannelInput& c) {
  auto sorted = c.ahead_us;
  auto* const end = sorted.data() + std::min(static_cast<std::size_t>(c.stamps), kRecentStamps);
  auto* const middle = sorted.data() + (end - sorted.data()) / 2;
  std::nth_element(sorted.data(), middle, end);
  return static_cast<double>(*middle);
}

std::string stampsOf(const std::string& channel, const ChannelInput& c) {
  return fmt::format("the stamps of {} ({} .. {})", channel, c.lowest_stamp_us, c.highest_stamp_us);
}

void addFault(const std::string& channel, const ChannelInput* c, std::vector<std::string>& lines) {
  if (c == nullptr || c->stamps < kEnoughStamps) {
    return;
  }
  if (c->lowest_stamp_us == c->highest_stamp_us) {
    lines.push_back(fmt::format("all {} stamps of {} are the same, {}", c->stamps, channel, c->lowest_stamp_us));
  } else if (const char* unit = wrongUnit(*c)) {
    lines.push_back(fmt::format("{} look like {}: utime must be in microseconds", stampsOf(channel, *c), unit));
  }
}

/// What the stamps of two channels that never meet have to do with one another; empty when they meet.
std::string explainApart(const LcmConfig& lcm, const ChannelInput& cloud, const ChannelInput& odometry) {
  const Micros before_us = difference(odometry.lowest_stamp_us, cloud.highest_stamp_us);
  const Micros after_us = difference(cloud.lowest_stamp_us, odometry.highest_stamp_us);
  if (std::max(before_us, after_us) < kApart_us) {
    return {};
  }
  return fmt::format("{} lie {} {} those of {} ({} .. {}): another clock or unit", stampsOf(lcm.lidar_semantic, cloud),
                     timeText(static_cast<double>(std::max(before_us, after_us))), before_us > 0 ? "before" : "after",
                     lcm.odometry, odometry.lowest_stamp_us, odometry.highest_stamp_us);
}

/// Nothing came on a channel, or messages of another type did.
std::string explainSilence(const char* key, const std::string& channel, const char* wanted, const ChannelInput* c,
                           std::int64_t of_type) {
  if (c == nullptr) {
    return fmt::format("nothing came on {} (lcm.{}, {})", channel, key, wanted);
  }
  return of_type == 0 ? fmt::format("none of the {} messages on {} (lcm.{}) is a {}", c->messages, channel, key, wanted)
                      : "";
}

}  // namespace

void InputWatch::add(const std::string& channel, Micros arrival_us, Bytes message) {
  ChannelInput& c = channels_[channel];
  c.first_arrival_us = c.messages == 0 ? arrival_us : c.first_arrival_us;
  c.last_arrival_us = arrival_us;
  ++c.messages;
  const auto head = peekHead(message);
  if (!head || head->kind == MessageKind::kOther) {
    return;
  }
  ++(head->kind == MessageKind::kPose ? c.poses : head->kind == MessageKind::kCloud ? c.clouds : c.images);
  const Micros stamp_us = head->utime_us;
  c.lowest_stamp_us = c.stamps == 0 ? stamp_us : std::min(c.lowest_stamp_us, stamp_us);
  c.highest_stamp_us = c.stamps == 0 ? stamp_us : std::max(c.highest_stamp_us, stamp_us);
  measureRate(c, arrival_us, stamp_us);
  c.ahead_us[static_cast<std::size_t>(c.stamps++) % kRecentStamps] = difference(stamp_us, arrival_us);
}

const ChannelInput* InputWatch::find(const std::string& channel) const {
  const auto it = channels_.find(channel);
  return it == channels_.end() ? nullptr : &it->second;
}

std::vector<std::string> InputWatch::faults(const LcmConfig& lcm) const {
  std::vector<std::string> lines;
  addFault(lcm.lidar_semantic, find(lcm.lidar_semantic), lines);
  addFault(lcm.odometry, find(lcm.odometry), lines);
  return lines;
}

std::vector<std::string> InputWatch::oddities(const LcmConfig& lcm) const {
  const ChannelInput *cloud = find(lcm.lidar_semantic), *odometry = find(lcm.odometry);
  if (cloud == nullptr || odometry == nullptr || cloud->stamps < kEnoughStamps || odometry->stamps < kEnoughStamps ||
      cloud->first_arrival_us == cloud->last_arrival_us) {
    return {};
  }
  const double ahead_us = aheadOfArrival_us(*cloud) - aheadOfArrival_us(*odometry);
  if (std::abs(ahead_us) < kClocksDiffer_us) {
    return {};
  }
  return {fmt::format("the stamps of {} are {} {} those of {} that came at the same time: do their clocks differ?",
                      lcm.lidar_semantic, timeText(ahead_us), ahead_us > 0 ? "ahead of" : "behind", lcm.odometry)};
}

std::string InputWatch::listChannels() const {
  std::vector<std::string> out;
  for (const auto& [name, c] : channels_) {
    const char* type = c.poses > 0    ? " bot_core.pose_t"
                       : c.clouds > 0 ? " bot_core.pointcloud2_t"
                       : c.images > 0 ? " images"
                                      : "";
    out.push_back(fmt::format("{}: {}{}", name, c.messages, type));
    if (out.size() == kMostListed && channels_.size() > kMostListed) {
      out.push_back(fmt::format("and {} more", channels_.size() - kMostListed));
      break;
    }
  }
  return join(out, ", ");
}

std::string InputWatch::explainNoFrames(const LcmConfig& lcm, const RunCounts& counts) const {
  const ChannelInput *cloud = find(lcm.lidar_semantic), *odometry = find(lcm.odometry);
  std::vector<std::string> why = faults(lcm);
  why.push_back(explainSilence("lidar_semantic", lcm.lidar_semantic, "bot_core.pointcloud2_t", cloud,
                               cloud != nullptr ? cloud->clouds + cloud->images : 0));
  why.push_back(
      explainSilence("odometry", lcm.odometry, "bot_core.pose_t", odometry, odometry != nullptr ? odometry->poses : 0));
  if (cloud != nullptr && odometry != nullptr && cloud->stamps > 0 && odometry->stamps > 0) {
    why.push_back(explainApart(lcm, *cloud, *odometry));
  }
  std::erase(why, "");
  for (const auto& [reason, messages] : counts.decode_errors) {
    why.push_back(fmt::format("{} messages unreadable ({})", messages, reason));
  }
  for (const auto& [cause, clouds] : counts.drops.causes) {
    why.push_back(fmt::format("{} clouds dropped ({})", clouds, cause));
  }
  return fmt::format("no frame could be mapped: {}; channels: {}", join(why, "; "), listChannels());
}

}  // namespace hgg
