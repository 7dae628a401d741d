#include "snapshot.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "map/file.h"

namespace hgg {
namespace {

/// Mapping goes first where there are fewer cores than threads.
constexpr int kNice = 10;
/// Writing takes no more than this share of the time.
constexpr double kMostShare = 0.1;

/// Lowers the priority of this thread alone, which is what Linux takes a thread's id for.
void giveWay() { ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice); }

}  // namespace

void SnapshotWriter::offer(const Map& map, Clock::time_point now) {
  if (every_s_ <= 0 || map.keyframes().poses().empty()) {
    return;
  }
  const auto every = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(every_s_));
  if (std::exchange(is_first_, false)) {
    due_ = now + every;
  }
  if (now < due_ || (writing_.valid() && writing_.wait_for(Clock::duration::zero()) != std::future_status::ready)) {
    return;
  }
  collect();
  const auto least = std::chrono::duration_cast<Clock::duration>(last_.took / kMostShare);
  due_ = now + std::max(every, least);
  // The last one to hold the copy is the writing thread: it takes the time to let go of it, too.
  writing_ = std::async(std::launch::async, [copy = std::make_unique<Map>(map), path = path_]() mutable {
    giveWay();
    const Clock::time_point start = Clock::now();
    Written written{saveMap(*copy, path), {}};
    copy.reset();
    written.took = Clock::now() - start;
    return written;
  });
}

void SnapshotWriter::collect() {
  if (!writing_.valid()) {
    return;
  }
  last_ = writing_.get();
  if (!last_.error.empty() && last_.error != warned_) {
    spdlog::warn("{}; mapping goes on, and it is tried again", last_.error);
  }
  warned_ = last_.error;
}

std::string SnapshotWriter::finish() {
  collect();
  return last_.error;
}

}  // namespace hgg
