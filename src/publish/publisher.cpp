#include "publish/publisher.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "publish/graph_update.h"

namespace hgg {
namespace {

constexpr Micros kStatus_us = 1'000'000;     // period of the status
constexpr Micros kComplete_us = 10'000'000;  // period of the complete graph, for late joiners
constexpr Micros kCompleteShare = 50;        // it may take one part in this many of our time
constexpr Micros kIdle_us = 60'000'000;      // the complaint that nothing comes is repeated this often

}  // namespace

Publisher::Publisher(const Mapper& mapper, std::vector<Sink> sinks, Clock clock)
    : mapper_(mapper),
      sinks_(std::move(sinks)),
      clock_(std::move(clock)),
      ground_(mapper, sinks_),
      goals_(mapper, sinks_) {
  last_.time_us = next_complete_us_ = next_idle_us_ = clock_();
}

template <typename Message>
void Publisher::send(std::function<void(const Message&)> Sink::*channel, const Message& message) {
  for (const Sink& sink : sinks_) {
    if (sink.*channel) {
      (sink.*channel)(message);
    }
  }
}

FrameTiming Publisher::publishFrame(const StepReport& report, FrameTiming timing) {
  const Micros start_us = clock_();
  send(&Sink::pose, PoseUpdate{report.utime_us, report.T_map_body, report.T_map_odom});
  send(&Sink::graph, changedGraph(mapper_, report, moves_.next(report.delta)));
  const double publish_ms = static_cast<double>(clock_() - start_us) * 1e-3;
  timing.stage_ms.emplace_back("publish", publish_ms);
  timing.frame_ms += publish_ms;
  ground_.follow(report);
  goals_.follow(report);
  latest_ = {report.utime_us,       timing,          nameOf(report.source), report.degenerate,    report.tracking,
             report.odometry_fault, report.fragment, report.pose_cov,       report.paging_trouble};
  warnOfAlarms();
  return timing;
}

void Publisher::tick(const RunCounts& counts) {
  const Micros now_us = clock_();
  ground_.tick(now_us);
  if (now_us - last_.time_us < kStatus_us) {
    return;
  }
  CountsAt now{now_us, counts};
  send(&Sink::status, describeHealth(latest_, last_, now, mapper_.map(), mapper_.config().lcm.odometry));
  warnOfIdleness(now);
  warnOfTroubles(now);
  if (now_us >= next_complete_us_) {
    publishCompleteGraph(now_us);
  }
  last_ = std::move(now);
}

/// Said at once, then once a minute for as long as it lasts.
void Publisher::warnOfIdleness(const CountsAt& now) {
  if (now.counts.frames > last_.counts.frames) {
    next_idle_us_ = now.time_us;
  } else if (now.time_us >= next_idle_us_) {
    next_idle_us_ = now.time_us + kIdle_us;
    send(&Sink::warning, explainIdleness(last_.counts, now.counts, mapper_.config().lcm));
  }
}

/// Each alarm is said once when it begins.
void Publisher::warnOfAlarms() {
  std::set<std::string> now;
  for (const Alarm& alarm : alarmsOf(latest_, last_.counts.odometry_delay_s, mapper_.config().lcm.odometry)) {
    now.insert(alarm.code);
    if (!told_.contains(alarm.code)) {
      send(&Sink::warning, alarm.text);
    }
  }
  told_ = std::move(now);
}

void Publisher::warnOfTroubles(const CountsAt& now) {
  for (const std::string& line : describeTroubles(last_.counts, now.counts)) {
    send(&Sink::warning, line);
  }
  std::int64_t unsent = 0;
  for (const Sink& sink : sinks_) {
    unsent += sink.take_unsent ? sink.take_unsent() : 0;
  }
  if (unsent > 0) {
    send(&Sink::warning, fmt::format("{} messages could not be published", unsent));
  }
}

/// A large graph takes its time: the next one waits so long that all of them together take their share and no more.
void Publisher::publishCompleteGraph(Micros now_us) {
  send(&Sink::graph, completeGraph(mapper_, latest_.utime_us));
  moves_.clear();
  next_complete_us_ = now_us + std::max(kComplete_us, kCompleteShare * (clock_() - now_us));
}

}  // namespace hgg
