#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "mapper.h"
#include "publish/command_desk.h"
#include "publish/ground_maker.h"

namespace hgg {

/// Publishes where the robot can walk and what is occupied around it at the configured rates, and of any rectangle on
/// command, and now and then the regions of the map. It is made on a thread of its own, of a copy of what has changed,
/// so that no frame waits for it: while the thread is at work, what is due waits. The grid around the robot follows
/// every frame, a part of it at a time.
class GroundPublisher {
 public:
  /// Without a sink for grids, OctoMaps or regions nothing is done, and without one for grids or OctoMaps commands are
  /// refused. `mapper` and the sinks must
  /// outlive it.
  GroundPublisher(const Mapper& mapper, std::vector<Sink> sinks);
  /// Waits for what the thread is at.
  ~GroundPublisher();
  GroundPublisher(const GroundPublisher&) = delete;
  GroundPublisher& operator=(const GroundPublisher&) = delete;

  /// After every frame.
  void follow(const StepReport& report);
  void ask(const Command& command);
  /// Several times a second: starts what is due, sends the answers that are there.
  void tick(Micros now_us);
  /// Waits until all that was started is done, and sends the answers. Commands that came meanwhile are carried out too.
  void settle(Micros now_us);

 private:
  void work(const std::stop_token& stop);
  bool isDue(double rate, Micros& next_us, Micros now_us) const;
  void startDue(Micros now_us);
  GroundJob nextJob();
  void sendReplies();
  void reply(const CommandReply& reply) const;

  const Mapper& mapper_;
  std::vector<Sink> sinks_;
  bool has_grid_ = false, has_octomap_ = false, has_regions_ = false;  // somebody takes them
  CommandDesk desk_;
  std::vector<Command> commands_;  // accepted, not started
  std::vector<NodeId> touched_;    // since the last job; ascending once it starts
  bool has_copy_ = false;          // the maker has the whole map as of the last job
  Micros utime_us_ = 0;            // of the newest frame
  Vec3 p_map_body_ = Vec3::Zero();
  bool has_news_ = false;    // a frame since the last grid that is sent was started
  bool is_followed_ = true;  // no frame since the last job
  Micros next_grid_us_ = 0, next_octomap_us_ = 0, next_regions_us_ = 0;

  GroundMaker maker_;  // the thread's own
  std::mutex mutex_;   // guards what follows
  std::condition_variable_any wake_;
  std::optional<GroundJob> job_;
  bool is_busy_ = false;
  std::vector<CommandReply> replies_;
  std::jthread thread_;  // last: joined before anything above goes
};

}  // namespace hgg
