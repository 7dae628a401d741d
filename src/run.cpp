#include "run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "bus/bus.h"
#include "publish/publish.h"

namespace hgg {
namespace {

constexpr std::chrono::milliseconds kPoll(100);  // how soon `stop` is seen
constexpr Micros kStatus_us = 1'000'000;         // period of status message and log line
constexpr Micros kComplete_us = 10'000'000;      // period of the complete graph, for late joiners
constexpr Micros kCompleteShare = 50;            // it may take one part in this many of our time
constexpr Micros kIdle_us = 60'000'000;          // a standing complaint is repeated this often

/// Says to the world what the mapper does: results a frame, status a second, the whole graph now and then.
class Reporter {
 public:
  Reporter(const LcmConfig& lcm, const Mapper& mapper, Bus& bus) : lcm_(lcm), mapper_(mapper), bus_(bus) {}

  /// Publishes what a step found; returns its timing with the publishing added.
  FrameTiming frame(const StepReport& report, FrameTiming timing);
  void tick(Micros now_us, const PipelineCounts& counts);

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& message) {
    if (!bus_.publish(channel, message)) ++unsent_;
  }
  Status status(Micros now_us, const PipelineCounts& counts) const;
  void sendCompleteGraph(Micros now_us);
  void logStatus(const Status& status) const;
  void logIdle(Micros now_us, const PipelineCounts& counts);
  void logTroubles(const PipelineCounts& counts);

  const LcmConfig& lcm_;
  const Mapper& mapper_;
  Bus& bus_;
  Micros last_utime_us_ = 0;  // of the newest frame
  FrameTiming last_timing_;
  std::string last_alignment_;
  int last_degenerate_ = 0;
  Micros start_us_ = Bus::now_us(), last_tick_us_ = start_us_, next_complete_us_ = start_us_, next_idle_us_ = start_us_;
  PipelineCounts last_counts_;  // at the last tick
  std::int64_t unsent_ = 0;
};

FrameTiming Reporter::frame(const StepReport& report, FrameTiming timing) {
  const Micros start_us = Bus::now_us();
  send(lcm_.pose_map, encodePose(report.utime_us, report.T_map_body));
  send(lcm_.map_odom, encodeRigidTransform(report.utime_us, report.T_map_odom));
  send(lcm_.map_objects, encodeGraphUpdate(changedGraph(mapper_, report)));
  const double publish_ms = static_cast<double>(Bus::now_us() - start_us) * 1e-3;
  timing.stage_ms.emplace_back("publish", publish_ms);
  timing.frame_ms += publish_ms;
  last_utime_us_ = report.utime_us;
  last_timing_ = timing;
  last_alignment_ = nameOf(report.source);
  last_degenerate_ = report.degenerate;
  return timing;
}

void Reporter::tick(Micros now_us, const PipelineCounts& counts) {
  if (now_us - last_tick_us_ < kStatus_us) return;
  const Status now = status(now_us, counts);
  send(lcm_.status, encodeStatus(now));
  if (counts.frames > last_counts_.frames) {
    logStatus(now);
    next_idle_us_ = now_us;
  } else {
    logIdle(now_us, counts);
  }
  logTroubles(counts);
  if (now_us >= next_complete_us_) sendCompleteGraph(now_us);
  last_counts_ = counts;
  last_tick_us_ = now_us;
}

Status Reporter::status(Micros now_us, const PipelineCounts& counts) const {
  Status out;
  out.utime_us = last_utime_us_;
  out.frames = counts.frames;
  out.dropped_busy = counts.drops.busy;
  out.dropped_odometry = counts.drops.odometry;
  out.dropped_invalid = counts.drops.invalid;
  out.frame_rate =
      static_cast<double>(counts.frames - last_counts_.frames) * 1e6 / static_cast<double>(now_us - last_tick_us_);
  out.frame_ms = last_timing_.frame_ms;
  out.stage_ms = last_timing_.stage_ms;
  out.unknown_labels = counts.unknown_labels;
  out.rss_mb = residentMegabytes();
  out.alignment = last_alignment_;
  out.degenerate = last_degenerate_;
  describeMap(mapper_.map(), out);
  return out;
}

void Reporter::sendCompleteGraph(Micros now_us) {
  send(lcm_.map_objects, encodeGraphUpdate(completeGraph(mapper_, last_utime_us_)));
  next_complete_us_ = now_us + std::max(kComplete_us, kCompleteShare * (Bus::now_us() - now_us));
}

void Reporter::logStatus(const Status& s) const {
  spdlog::info(
      "{:4.1f} Hz, {:5.1f} ms | {} objects, {} leaves, map {:.1f} MB | dropped: {} busy, {} no odometry, {} invalid | "
      "{:.0f} MB | {}{}",
      s.frame_rate, s.frame_ms, s.objects, s.leaves, s.map_mb, s.dropped_busy, s.dropped_odometry, s.dropped_invalid,
      s.rss_mb, s.alignment, s.degenerate > 0 ? fmt::format(" ({} of 6)", s.degenerate) : "");
}

/// Why there was no frame in the last second; said at once, then once a minute.
void Reporter::logIdle(Micros now_us, const PipelineCounts& counts) {
  if (now_us < next_idle_us_) return;
  next_idle_us_ = now_us + kIdle_us;
  const bool has_clouds = counts.drops.total() > last_counts_.drops.total();
  const bool has_odometry = counts.odometry_samples > last_counts_.odometry_samples;
  spdlog::warn("no frames: clouds on {} {}, odometry on {} {}", lcm_.lidar_semantic,
               has_clouds ? "come but are dropped" : "do not come", lcm_.odometry,
               has_odometry ? "comes" : "does not come");
}

/// What went wrong in the last second.
void Reporter::logTroubles(const PipelineCounts& counts) {
  for (const auto& [reason, messages] : counts.decode_errors) {
    const auto before = last_counts_.decode_errors.find(reason);
    const std::int64_t more = messages - (before == last_counts_.decode_errors.end() ? 0 : before->second);
    if (more > 0) spdlog::warn("{} messages unreadable: {} ({} in all)", more, reason, messages);
  }
  if (counts.restarts > last_counts_.restarts) spdlog::warn("time went back: going on from the new time and odometry");
  if (unsent_ > 0) spdlog::warn("{} messages could not be published", std::exchange(unsent_, 0));
}

/// Hands the pipeline what came in. Odometry first: it may belong to the cloud.
void feed(Pipeline& pipeline, const Inbox& inbox) {
  for (const auto& message : inbox.odometry) pipeline.addOdometry(message);
  if (inbox.odometry_lost > 0) spdlog::warn("{} odometry messages lost: mapper long busy", inbox.odometry_lost);
  pipeline.countBusy(inbox.clouds_replaced);
  if (inbox.cloud) pipeline.addCloud(inbox.cloud->bytes, inbox.cloud->arrival_us);
}

}  // namespace

Result<PipelineCounts> runLive(const Config& config, Mapper& mapper, const std::atomic<bool>& stop,
                               const OnFrame& on_frame) {
  auto opened = Bus::open(config.lcm);
  if (!opened) return Result<PipelineCounts>::fail(opened.error);
  Bus& bus = **opened;
  if (const auto warning = receiveBufferWarning(config.lcm.url, readSocketLimits()); !warning.empty()) {
    spdlog::warn(warning);
  }
  Reporter reporter(config.lcm, mapper, bus);
  Pipeline pipeline(mapper, [&](const StepReport& report, const FrameTiming& timing) {
    const FrameTiming whole = reporter.frame(report, timing);
    if (on_frame) on_frame(report, whole);
  });
  spdlog::info("listening to {} and {} at {}", config.lcm.lidar_semantic, config.lcm.odometry, config.lcm.url);
  while (!stop) {
    feed(pipeline, bus.take(kPoll));
    pipeline.stepReady(Bus::now_us());
    reporter.tick(Bus::now_us(), pipeline.counts());
  }
  pipeline.finish();
  return Result<PipelineCounts>::ok(pipeline.counts());
}

}  // namespace hgg
