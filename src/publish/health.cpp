#include "publish/health.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace hgg {

Status describeHealth(const LatestFrame& latest, const CountsAt& before, const CountsAt& now, const Map& map) {
  const RunCounts& counts = now.counts;
  Status out;
  out.utime_us = latest.utime_us;
  out.frames = counts.frames;
  out.dropped_busy = counts.drops.busy;
  out.dropped_odometry = counts.drops.odometry;
  out.dropped_invalid = counts.drops.invalid;
  out.frame_rate = static_cast<double>(counts.frames - before.counts.frames) * 1e6 /
                   static_cast<double>(now.time_us - before.time_us);
  out.frame_ms = latest.timing.frame_ms;
  out.stage_ms = latest.timing.stage_ms;
  out.unknown_labels = counts.unknown_labels;
  out.rss_mb = residentMegabytes();
  out.alignment = latest.alignment;
  out.degenerate = latest.degenerate;
  describeMap(map, out);
  return out;
}

void describeMap(const Map& map, Status& status) {
  status.objects = static_cast<std::int64_t>(map.confirmedCount());
  status.leaves = static_cast<std::int64_t>(map.leafCount());
  status.keyframes = std::ssize(map.keyframes().poses());
  status.loops = std::ranges::count_if(map.keyframes().edges(), &BetweenConstraint::is_loop);
  status.map_mb = map.megabytes();
  status.revision = map.revision();
}

std::string explainIdleness(const RunCounts& before, const RunCounts& now, const LcmConfig& lcm) {
  const bool has_clouds = now.drops.total() > before.drops.total();
  const bool has_odometry = now.odometry_samples > before.odometry_samples;
  return fmt::format("no frames: clouds on {} {}, odometry on {} {}", lcm.lidar_semantic,
                     has_clouds ? "come but are dropped" : "do not come", lcm.odometry,
                     has_odometry ? "comes" : "does not come");
}

std::vector<std::string> describeTroubles(const RunCounts& before, const RunCounts& now) {
  std::vector<std::string> lines;
  for (const auto& [reason, messages] : now.decode_errors) {
    const auto earlier = before.decode_errors.find(reason);
    const std::int64_t more = messages - (earlier == before.decode_errors.end() ? 0 : earlier->second);
    if (more > 0) {
      lines.push_back(fmt::format("{} messages unreadable: {} ({} in all)", more, reason, messages));
    }
  }
  if (now.restarts > before.restarts) {
    lines.emplace_back("time went back: going on from the new time and odometry");
  }
  return lines;
}

}  // namespace hgg
