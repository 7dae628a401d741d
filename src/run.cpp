#include "run.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>

#include "bus/bus.h"
#include "bus/codec.h"
#include "bus/lcm_sink.h"
#include "core/text.h"
#include "log_sink.h"
#include "publish/publisher.h"

namespace hgg {
namespace {

constexpr std::chrono::milliseconds kPoll(100);  // how soon `stop` is seen

/// Hands the pipeline what came in. Odometry first: it may belong to the cloud.
void feed(Pipeline& pipeline, const Inbox& inbox) {
  for (const RawMessage& message : inbox.odometry) {
    pipeline.addOdometry(message.bytes, message.arrival_us);
  }
  if (inbox.odometry_lost > 0) {
    spdlog::warn("{} odometry messages lost: mapper long busy", inbox.odometry_lost);
  }
  for (const SideMessage& message : inbox.sides) {
    pipeline.addRigMessage(message.channel, message.bytes, message.arrival_us);
  }
  pipeline.countBusy(inbox.clouds_replaced);
  if (inbox.cloud) {
    pipeline.addCloud(inbox.cloud->bytes, inbox.cloud->arrival_us);
  }
}

/// Requests that cannot be read cannot be answered: nobody knows who asks.
void carryOut(Publisher& publisher, Pipeline& pipeline, const Inbox& inbox) {
  for (const RawMessage& message : inbox.commands) {
    const Result<Command> command = decodeCommand(message.bytes);
    command ? publisher.ask(*command) : pipeline.countUnreadable("command: " + command.error);
  }
  for (const RawMessage& message : inbox.queries) {
    const Result<GoalQuery> query = decodeGoalQuery(message.bytes);
    query ? publisher.ask(*query) : pipeline.countUnreadable("goal query: " + query.error);
  }
}

}  // namespace

Result<RunCounts> runLive(const Config& config, Mapper& mapper, const std::atomic<bool>& stop, const OnFrame& on_frame,
                          const std::optional<Rig>& rig) {
  auto opened = Bus::open(config.lcm, rig ? RigInput(*rig, config).sideChannels() : std::vector<std::string>{});
  if (!opened) {
    return Result<RunCounts>::fail(opened.error);
  }
  Bus& bus = **opened;
  if (const auto warning = receiveBufferWarning(config.lcm.url, readSocketLimits()); !warning.empty()) {
    spdlog::warn(warning);
  }
  Publisher publisher(mapper, {lcmSink(bus, config.lcm), logSink()}, Bus::now_us);
  Pipeline pipeline(
      mapper,
      [&](const StepReport& report, const FrameTiming& timing) {
        const FrameTiming whole = publisher.publishFrame(report, timing);
        if (on_frame) {
          on_frame(report, whole);
        }
      },
      OdometryWait::kConfigured, rig);
  std::vector<std::string> channels = pipeline.rigChannels();
  channels.insert(channels.begin(), config.lcm.lidar_semantic);
  spdlog::info("listening to {} and {} at {}", join(channels, ", "), config.lcm.odometry, config.lcm.url);
  while (!stop) {
    const Inbox inbox = bus.take(kPoll);
    carryOut(publisher, pipeline, inbox);
    feed(pipeline, inbox);
    pipeline.stepReady(Bus::now_us());
    publisher.tick(pipeline.counts());
  }
  pipeline.finish(Bus::now_us());
  if (pipeline.frames() == 0) {
    return Result<RunCounts>::fail(pipeline.inputs().explainNoFrames(config.lcm, pipeline.counts()));
  }
  return Result<RunCounts>::ok(pipeline.counts());
}

}  // namespace hgg
