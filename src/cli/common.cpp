#include "cli/common.h"

#include <fmt/format.h>

#include <csignal>

namespace hgg {
namespace {

std::atomic<bool> g_stop{false};  // a signal handler can reach nothing else

}  // namespace

int fail(const std::string& error) {
  fmt::print(stderr, "hggmap: {}\n", error);
  return kBadInput;
}

const std::atomic<bool>& stopOnSignals() {
  const auto handler = [](int signal) {
    g_stop = true;
    std::signal(signal, SIG_DFL);
  };
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  std::signal(SIGHUP, handler);  // a dropped terminal session must not cost the map
  return g_stop;
}

void summarise(const Mapper& mapper, const RunCounts& counts, const OutputDirectory& out) {
  const FrameDrops& drops = counts.drops;
  fmt::print("{} frames, {} dropped (busy {}, no odometry {}, invalid {})\n", counts.frames, drops.total(), drops.busy,
             drops.odometry, drops.invalid);
  for (const auto& [reason, messages] : counts.decode_errors) {
    fmt::print("  {} messages unreadable: {}\n", messages, reason);
  }
  if (counts.restarts > 0) {
    fmt::print("  time went back {} times (restarts of the robot or the log)\n", counts.restarts);
  }
  if (counts.unknown_labels > 0) {
    fmt::print("  {} points had labels outside the class table and were ignored\n", counts.unknown_labels);
  }
  fmt::print("map: {} objects, {} leaves, {:.1f} MB -> {}\n", mapper.map().confirmedCount(), mapper.map().leafCount(),
             mapper.map().megabytes(), out.path("map.hgg"));
}

}  // namespace hgg
