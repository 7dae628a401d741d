#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "mapper.h"
#include "publish/goal_publisher.h"
#include "publish/graph_update.h"
#include "publish/ground_publisher.h"
#include "publish/health.h"
#include "publish/messages.h"
#include "stats.h"

namespace hgg {

/// Tells the sinks what the mapper does: the results of every frame, a status a second, the whole graph now and then
/// for those who joined late, where the robot can walk at the configured rate, and a warning where something is wrong.
/// What a sink makes of it is the sink's affair.
class Publisher {
 public:
  using Clock = std::function<Micros()>;  // must not go back

  /// `mapper` must outlive the publisher.
  Publisher(const Mapper& mapper, std::vector<Sink> sinks, Clock clock);

  /// Publishes what a step found. Returns the cost of the frame with a stage "publish" added.
  FrameTiming publishFrame(const StepReport& report, FrameTiming timing);
  /// Publishes what is due by the clock; to be called several times a second, frames or not.
  void tick(const RunCounts& counts);
  /// Carries out a command, or says why not; the answer comes when all of it is done.
  void ask(const Command& command) { ground_.ask(command); }
  /// Answers a query, as soon as the answer is found.
  void ask(const GoalQuery& query) { goals_.ask(query); }
  /// Waits for what is being made, and sends it.
  void settle() {
    ground_.settle(clock_());
    goals_.settle();
  }

 private:
  template <typename Message>
  void send(std::function<void(const Message&)> Sink::*channel, const Message& message);
  void warnOfIdleness(const CountsAt& now);
  void warnOfAlarms();
  void warnOfTroubles(const CountsAt& now);
  void publishCompleteGraph(Micros now_us);

  const Mapper& mapper_;
  std::vector<Sink> sinks_;
  Clock clock_;
  MoveQueue moves_;
  GroundPublisher ground_;
  GoalPublisher goals_;
  LatestFrame latest_;
  std::set<std::string> told_;              // codes of the alarms there are
  CountsAt last_;                           // at the last status
  Micros next_complete_us_, next_idle_us_;  // not before these
};

}  // namespace hgg
