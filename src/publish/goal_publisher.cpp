#include "publish/goal_publisher.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/signals.h"

namespace hgg {
namespace {

std::tuple<std::string, std::int64_t, std::string> keyOf(const GoalQuery& query) {
  return {query.client, query.request_id, query.text};
}

}  // namespace

GoalPublisher::GoalPublisher(const Mapper& mapper, std::vector<Sink> sinks)
    : mapper_(mapper), sinks_(std::move(sinks)), answerer_(mapper.config().traversability) {
  if (std::ranges::any_of(sinks_, [](const Sink& s) { return static_cast<bool>(s.goal); })) {
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  }
}

GoalPublisher::~GoalPublisher() = default;

void GoalPublisher::work(const std::stop_token& stop) {
  leaveSignalsToMainThread();
  answerer_.lexiconOf({});  // reads WordNet, so that the first who asks need not wait for that
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return !jobs_.empty(); }) && !stop.stop_requested()) {
    Job job = std::move(jobs_.front());
    lock.unlock();
    // What a lost robot was told is worth nothing once it knows where it is.
    const bool has_start = job.first.T_map_body || job.second.start;
    const GoalReply reply = answerer_.answer(std::move(job.first), job.second);
    send(reply);
    lock.lock();
    const bool is_lasting = has_start && reply.status != GoalStatus::kFailed;
    desk_.close(keyOf(job.second), is_lasting ? std::optional(reply) : std::nullopt);
    jobs_.pop_front();
    wake_.notify_all();
  }
}

void GoalPublisher::follow(const StepReport& report) {
  utime_us_ = report.utime_us;
  T_map_body_ = report.tracking == Tracking::kLost ? std::nullopt : std::optional(report.T_map_body);
}

void GoalPublisher::ask(const GoalQuery& query) {
  if (!thread_.joinable()) {
    return;
  }
  if (const std::optional<GoalReply> reply = takeIn(query)) {
    send(*reply);
  }
}

std::optional<GoalReply> GoalPublisher::takeIn(const GoalQuery& query) {
  const Map& map = mapper_.map();
  if (map.nodes().empty()) {
    return failure(query, "there is no map yet: ask again later");
  }
  const std::lock_guard lock(mutex_);
  Requests::Admission admission = desk_.admit(keyOf(query));
  if (admission.verdict == Requests::Verdict::kFull) {
    return failure(query, fmt::format("{} queries wait already: ask again later", Requests::kMostAtWork));
  }
  if (admission.verdict == Requests::Verdict::kNew) {
    jobs_.push_back({{allOf(map), map.classNames(), utime_us_, map.revision(), T_map_body_}, query});
    wake_.notify_all();
  }
  return std::move(admission.reply);
}

void GoalPublisher::settle() {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [this] { return jobs_.empty(); });
}

void GoalPublisher::send(const GoalReply& reply) {
  const std::lock_guard lock(sending_);
  for (const Sink& sink : sinks_) {
    if (sink.goal) {
      sink.goal(reply);
    }
  }
}

}  // namespace hgg
