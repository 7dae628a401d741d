#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "mapper.h"
#include "publish/desk.h"
#include "publish/goal_answerer.h"

namespace hgg {

/// Answers goal queries on a thread of its own, each of a copy of the map at the time it came, so that no frame waits.
/// The thread has the priority of mapping, because somebody waits. A reply is sent as soon as it is made.
class GoalPublisher {
 public:
  /// `mapper` and the sinks must outlive it. Without a sink for replies queries are dropped.
  GoalPublisher(const Mapper& mapper, std::vector<Sink> sinks);
  /// Waits for the answer that the thread is at; those that wait behind it are not given any more.
  ~GoalPublisher();
  GoalPublisher(const GoalPublisher&) = delete;
  GoalPublisher& operator=(const GoalPublisher&) = delete;

  /// After every frame.
  void follow(const StepReport& report);
  void ask(const GoalQuery& query);
  /// Waits until all that was asked is answered.
  void settle();

 private:
  using Job = std::pair<AskedMap, GoalQuery>;
  /// Client, request_id and text: a client that began anew may use its numbers again.
  using Requests = Desk<std::tuple<std::string, std::int64_t, std::string>, GoalReply>;

  void work(const std::stop_token& stop);
  /// The reply that can be sent at once: from memory, or that there is no answer. Nothing where the thread will answer.
  std::optional<GoalReply> takeIn(const GoalQuery& query);
  void send(const GoalReply& reply);

  const Mapper& mapper_;
  std::vector<Sink> sinks_;
  Micros utime_us_ = 0;             // of the newest frame
  std::optional<Pose> T_map_body_;  // nothing while lost

  std::mutex sending_;     // replies go out one at a time
  GoalAnswerer answerer_;  // the thread's own
  std::mutex mutex_;       // guards what follows
  std::condition_variable_any wake_;
  Requests desk_;
  std::deque<Job> jobs_;  // the one at work is the first
  std::jthread thread_;   // last: joined before anything above goes
};

}  // namespace hgg
