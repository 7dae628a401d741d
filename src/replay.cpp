#include "replay.h"

#include <set>

namespace hgg {
namespace {

std::string join(const std::set<std::string>& names) {
  std::string out;
  for (const auto& name : names) {
    out += (out.empty() ? "" : ", ") + name;
  }
  return out;
}

/// Why a log gave no cloud at all, and what to do about it.
std::string explainNoClouds(const std::string& log_path, const LcmConfig& lcm, const std::set<std::string>& channels) {
  if (channels.empty()) {
    return "no LCM event in '" + log_path + "': is it an LCM log (as lcm-logger writes them)?";
  }
  return "no cloud on channel " + lcm.lidar_semantic + " in '" + log_path + "' (its channels: " + join(channels) +
         "): set lcm.lidar_semantic in the config";
}

}  // namespace

Result<ReplayReport> replayLog(const std::string& log_path, Mapper& mapper, const OnFrame& on_frame,
                               const OnProgress& on_progress, const std::atomic<bool>& stop) {
  auto log = LogReader::open(log_path);
  if (!log) {
    return Result<ReplayReport>::fail(log.error);
  }
  const LcmConfig& lcm = mapper.config().lcm;
  Pipeline pipeline(mapper, on_frame);
  ReplayReport report;
  std::set<std::string> channels;
  while (!(report.stopped = stop)) {
    const auto event = log->next();
    if (!event) {
      break;
    }
    ++report.events;
    channels.insert(event->channel);
    pipeline.stepReady(
        event->timestamp_us);  // first, so that odometry beyond the wait comes too late, as it would live
    if (event->channel == lcm.odometry) {
      pipeline.addOdometry(event->data);
    }
    if (event->channel == lcm.lidar_semantic) {
      pipeline.addCloud(event->data, event->timestamp_us);
    }
    pipeline.stepReady(event->timestamp_us);
    if (on_progress) {
      on_progress(log->progress(), pipeline.counts().frames);
    }
  }
  if (!report.stopped && !channels.contains(lcm.lidar_semantic)) {
    return Result<ReplayReport>::fail(explainNoClouds(log_path, lcm, channels));
  }
  pipeline.finish();
  report.counts = pipeline.counts();
  report.loss = log->loss();
  return Result<ReplayReport>::ok(std::move(report));
}

}  // namespace hgg
