#include "replay.h"

#include <utility>

#include "core/text.h"

namespace hgg {
namespace {

void feed(Pipeline& pipeline, const LcmConfig& lcm, const LogEvent& event) {
  if (event.channel == lcm.odometry) {
    pipeline.addOdometry(event.data, event.timestamp_us);
  }
  if (event.channel == lcm.lidar_semantic) {
    pipeline.addCloud(event.data, event.timestamp_us);
  }
  if (pipeline.isRigChannel(event.channel)) {
    pipeline.addRigMessage(event.channel, event.data, event.timestamp_us);
  } else if (event.channel != lcm.odometry && event.channel != lcm.lidar_semantic) {
    pipeline.addOther(event.channel, event.data, event.timestamp_us);
  }
}

/// Why no map should be made of a log, and what to do about it; empty when there is no reason.
std::string explainNoMap(const std::string& log_path, const LcmConfig& lcm, const Pipeline& pipeline) {
  const InputWatch& inputs = pipeline.inputs();
  if (inputs.isEmpty()) {
    return "no LCM event in '" + log_path + "': is it an LCM log (as lcm-logger writes them)?";
  }
  if (pipeline.frames() == 0) {
    return "'" + log_path + "': " + inputs.explainNoFrames(lcm, pipeline.counts());
  }
  const std::string faults = join(inputs.faults(lcm), "; ");
  return faults.empty() ? "" : "'" + log_path + "': no map is made of it: " + faults;
}

}  // namespace

Result<ReplayReport> replayLog(const std::string& log_path, Mapper& mapper, const OnFrame& on_frame,
                               const OnProgress& on_progress, const std::atomic<bool>& stop,
                               const std::optional<Rig>& rig) {
  auto log = LogReader::open(log_path);
  if (!log) {
    return Result<ReplayReport>::fail(log.error);
  }
  const LcmConfig& lcm = mapper.config().lcm;
  Pipeline pipeline(mapper, on_frame, OdometryWait::kUnlimited, rig);
  ReplayReport report;
  Micros now_us = 0;
  while (!(report.stopped = stop)) {
    const auto event = log->next();
    if (!event) {
      break;
    }
    ++report.events;
    now_us = event->timestamp_us;
    feed(pipeline, lcm, *event);
    pipeline.stepReady(now_us);
    if (on_progress) {
      on_progress(log->progress(), pipeline.frames());
    }
  }
  pipeline.finish(now_us);
  if (const std::string why = explainNoMap(log_path, lcm, pipeline); !why.empty()) {
    return Result<ReplayReport>::fail(report.stopped ? "stopped: " + why : why);
  }
  report.counts = pipeline.counts();
  report.loss = log->loss();
  return Result<ReplayReport>::ok(std::move(report));
}

}  // namespace hgg
