#include "publish/health.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hgg {

namespace {

/// Every loss of messages by its cause.
std::vector<std::pair<std::string, std::int64_t>> dropsOf(const RunCounts& counts) {
  std::vector<std::pair<std::string, std::int64_t>> out(counts.drops.causes.begin(), counts.drops.causes.end());
  const std::int64_t late = counts.odometry_rejected - counts.odometry_outliers;
  for (const auto& [cause, messages] :
       {std::pair("cloud: replaced by a newer one", counts.drops.busy),
        std::pair("odometry: sample late or twice", late),
        std::pair("odometry: sample with a stamp out of line", counts.odometry_outliers)}) {
    if (messages > 0) {
      out.emplace_back(cause, messages);
    }
  }
  out.insert(out.end(), counts.decode_errors.begin(), counts.decode_errors.end());
  if (counts.rig) {
    out.insert(out.end(), counts.rig->troubles.begin(), counts.rig->troubles.end());
  }
  return out;
}

/// A line for each cause of which there are more now.
void tellOfMore(const std::map<std::string, std::int64_t>& before, const std::map<std::string, std::int64_t>& now,
                const char* what, std::vector<std::string>& lines) {
  for (const auto& [cause, count] : now) {
    const auto earlier = before.find(cause);
    const std::int64_t more = count - (earlier == before.end() ? 0 : earlier->second);
    if (more > 0) {
      lines.push_back(fmt::format("{} {}: {} ({} in all)", more, what, cause, count));
    }
  }
}

}  // namespace

Status describeHealth(const LatestFrame& latest, const CountsAt& before, const CountsAt& now, const Map& map,
                      const std::string& odometry_channel) {
  const RunCounts& counts = now.counts;
  Status out;
  out.utime_us = latest.utime_us;
  out.frames = counts.frames;
  out.dropped_busy = counts.drops.busy;
  out.dropped_odometry = counts.drops.odometry;
  out.dropped_invalid = counts.drops.invalid;
  out.drops = dropsOf(counts);
  out.frame_rate = static_cast<double>(counts.frames - before.counts.frames) * 1e6 /
                   static_cast<double>(now.time_us - before.time_us);
  out.frame_ms = latest.timing.frame_ms;
  out.stage_ms = latest.timing.stage_ms;
  out.unknown_labels = counts.unknown_labels;
  out.rss_mb = residentMegabytes();
  out.alignment = latest.alignment;
  out.degenerate = latest.degenerate;
  if (!latest.alignment.empty()) {
    out.fragment = latest.fragment;
    out.position_sigma = std::sqrt(latest.pose_cov.diagonal().head<3>().maxCoeff());
    out.heading_sigma = std::sqrt(latest.pose_cov(5, 5));
    out.alarms = alarmsOf(latest, counts.odometry_delay_s, odometry_channel);
    for (const SensorTrouble& trouble : counts.rig ? counts.rig->standing : std::vector<SensorTrouble>{}) {
      out.alarms.push_back({false, trouble.code, trouble.sensor, trouble.text});
    }
    const bool is_lost = std::ranges::any_of(out.alarms, &Alarm::is_serious);
    out.state = is_lost ? HealthState::kLost : out.alarms.empty() ? HealthState::kOk : HealthState::kDegraded;
  }
  describeMap(map, out);
  return out;
}

std::vector<Alarm> alarmsOf(const LatestFrame& latest, double odometry_delay_s, const std::string& odometry) {
  std::vector<Alarm> alarms;
  if (latest.tracking == Tracking::kLost || latest.fragment != 0) {
    alarms.push_back({true, "lost", "", "the place in the map is not known: mapping goes on in a fragment of its own"});
  } else if (latest.tracking == Tracking::kDoubtful) {
    alarms.push_back({false, "doubtful", "", "the frame does not lie on the map as it should: it is left out"});
  }
  if (latest.odometry_fault != OdometryFault::kNone) {
    alarms.push_back({false, codeOf(latest.odometry_fault), odometry, describe(latest.odometry_fault)});
  }
  if (odometry_delay_s != 0) {
    alarms.push_back(
        {false, "odometry_lag", odometry,
         fmt::format("odometry's stamps lag {:.0f} ms behind the clouds': undone", odometry_delay_s * 1e3)});
  }
  if (!latest.paging_trouble.empty()) {
    alarms.push_back({false, "map_memory", "", latest.paging_trouble});
  }
  return alarms;
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
  tellOfMore(before.decode_errors, now.decode_errors, "messages unreadable", lines);
  tellOfMore(before.drops.causes, now.drops.causes, "clouds dropped", lines);
  if (now.rig) {
    tellOfMore(before.rig ? before.rig->troubles : std::map<std::string, std::int64_t>{}, now.rig->troubles,
               "frames or messages of a sensor", lines);
  }
  if (now.odometry_rejected > before.odometry_rejected) {
    lines.push_back(fmt::format("{} odometry samples rejected, {} of them with stamps out of line ({} in all)",
                                now.odometry_rejected - before.odometry_rejected,
                                now.odometry_outliers - before.odometry_outliers, now.odometry_rejected));
  }
  if (now.odometry_anew > before.odometry_anew) {
    lines.emplace_back("the odometry began anew: its clock went back, or it paused");
  }
  for (const std::string& line : now.oddities) {
    if (before.oddities.empty()) {
      lines.push_back(line);
    }
  }
  if (now.restarts > before.restarts) {
    lines.emplace_back("time went back: going on from the new time and odometry");
  }
  return lines;
}

}  // namespace hgg
