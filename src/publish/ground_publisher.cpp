#include "publish/ground_publisher.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/signals.h"

namespace hgg {
namespace {

/// Mapping goes first where there are fewer cores than threads.
constexpr int kNice = 10;
/// How often regions are found, Hz: takes some 0.1 s, and groups of things do not change fast.
constexpr double kRegionsRate = 0.2;

template <typename Message>
auto toAll(const std::vector<Sink>& sinks, std::function<void(const Message&)> Sink::*channel) {
  return [&sinks, channel](const Message& message) {
    for (const Sink& sink : sinks) {
      if (sink.*channel) {
        (sink.*channel)(message);
      }
    }
  };
}

}  // namespace

GroundPublisher::GroundPublisher(const Mapper& mapper, std::vector<Sink> sinks)
    : mapper_(mapper),
      sinks_(std::move(sinks)),
      has_grid_(std::ranges::any_of(sinks_, [](const Sink& s) { return static_cast<bool>(s.ground); })),
      has_octomap_(std::ranges::any_of(sinks_, [](const Sink& s) { return static_cast<bool>(s.octomap); })),
      has_regions_(std::ranges::any_of(sinks_, [](const Sink& s) { return static_cast<bool>(s.regions); })),
      maker_(mapper.config().traversability,
             {mapper.config().creation.sigma_floor, mapper.config().creation.edge_geometry_share},
             toAll(sinks_, &Sink::ground), toAll(sinks_, &Sink::octomap), toAll(sinks_, &Sink::regions)) {
  if (has_grid_ || has_octomap_ || has_regions_) {
    thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  }
}

GroundPublisher::~GroundPublisher() = default;

void GroundPublisher::work(const std::stop_token& stop) {
  leaveSignalsToMainThread();
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  std::unique_lock lock(mutex_);
  while (wake_.wait(lock, stop, [this] { return job_.has_value(); })) {
    GroundJob job = std::move(*job_);
    job_.reset();
    lock.unlock();
    std::vector<CommandReply> replies = maker_.carryOut(std::move(job));
    lock.lock();
    replies_.insert(replies_.end(), std::move_iterator(replies.begin()), std::move_iterator(replies.end()));
    is_busy_ = false;
    wake_.notify_all();
  }
}

void GroundPublisher::follow(const StepReport& report) {
  if (!thread_.joinable()) {
    return;
  }
  utime_us_ = report.utime_us;
  p_map_body_ = report.T_map_body.translation();
  has_news_ = true, is_followed_ = false;
  if (has_copy_) {
    const MapDelta& delta = report.delta;
    for (const auto* ids : {&delta.changed, &delta.moved, &delta.removed, &delta.left}) {
      touched_.insert(touched_.end(), ids->begin(), ids->end());
    }
  }
}

void GroundPublisher::ask(const Command& command) {
  CommandDesk::Admission admission = desk_.admit(command);
  if (admission.is_accepted && !has_grid_ && !has_octomap_) {
    desk_.answered(refusal(command, "nothing here can send it"));
    admission = desk_.admit(command);
  }
  if (admission.is_accepted) {
    commands_.push_back(command);
  }
  if (admission.reply) {
    reply(*admission.reply);
  }
}

void GroundPublisher::tick(Micros now_us) {
  if (thread_.joinable()) {
    sendReplies();
    startDue(now_us);
  }
}

void GroundPublisher::settle(Micros now_us) {
  while (thread_.joinable()) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return !is_busy_; });
    }
    sendReplies();
    if (commands_.empty()) {
      return;
    }
    startDue(now_us);
  }
}

bool GroundPublisher::isDue(double rate, Micros& next_us, Micros now_us) const {
  if (rate <= 0 || !has_news_ || now_us < next_us) {
    return false;
  }
  next_us = now_us + static_cast<Micros>(1e6 / rate);
  return true;
}

void GroundPublisher::startDue(Micros now_us) {
  {
    const std::lock_guard lock(mutex_);
    if (is_busy_) {
      return;
    }
  }
  const TraversabilityConfig& config = mapper_.config().traversability;
  const bool wants_grid = has_grid_ && isDue(config.publish_rate, next_grid_us_, now_us);
  const bool wants_octomap = has_octomap_ && isDue(config.octomap_rate, next_octomap_us_, now_us);
  const bool wants_regions = has_regions_ && isDue(kRegionsRate, next_regions_us_, now_us);
  const bool follows = has_grid_ && config.publish_rate > 0 && !is_followed_;
  if (!follows && !wants_grid && !wants_octomap && !wants_regions && commands_.empty()) {
    return;
  }
  GroundJob job = nextJob();
  is_followed_ = true;
  job.follows = follows, job.wants_grid = wants_grid, job.wants_octomap = wants_octomap;
  if (wants_regions) {
    job.wants_regions = mapper_.map().classNames();
  }
  has_news_ = has_news_ && !wants_grid && !wants_octomap;
  const std::lock_guard lock(mutex_);
  job_ = std::move(job);
  is_busy_ = true;
  wake_.notify_all();
}

GroundJob GroundPublisher::nextJob() {
  GroundJob job;
  std::ranges::sort(touched_);
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  job.changes = has_copy_ ? changesOf(mapper_.map(), touched_) : allOf(mapper_.map());
  has_copy_ = true;
  touched_.clear();
  job.utime_us = utime_us_;
  job.revision = mapper_.map().revision();
  job.p_map_body = p_map_body_;
  job.commands = std::exchange(commands_, {});
  return job;
}

void GroundPublisher::sendReplies() {
  std::vector<CommandReply> replies;
  {
    const std::lock_guard lock(mutex_);
    replies.swap(replies_);
  }
  for (const CommandReply& r : replies) {
    desk_.answered(r);
    reply(r);
  }
}

void GroundPublisher::reply(const CommandReply& reply) const { toAll(sinks_, &Sink::reply)(reply); }

}  // namespace hgg
