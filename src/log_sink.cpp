#include "log_sink.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace hgg {

Sink logSink() {
  Sink sink;
  sink.status = [](const Status& status) {
    if (status.frame_rate > 0) {  // else a warning says why not
      spdlog::info("{}", statusLine(status));
    }
  };
  sink.warning = [](const std::string& line) { spdlog::warn("{}", line); };
  sink.reply = [](const CommandReply& reply) {
    spdlog::info("command {} of '{}': {}{}", reply.request_id, reply.client, reply.ok ? "" : "refused: ", reply.text);
  };
  return sink;
}

std::string statusLine(const Status& s) {
  std::string alarms;
  for (const Alarm& alarm : s.alarms) {
    alarms += (alarms.empty() ? " | " : ", ") + alarm.code;
  }
  return fmt::format(
      "{:4.1f} Hz, {:5.1f} ms | {} objects, {} leaves, map {:.1f} MB | dropped: {} busy, {} no odometry, {} invalid | "
      "{:.0f} MB | {}{}{}",
      s.frame_rate, s.frame_ms, s.objects, s.leaves, s.map_mb, s.dropped_busy, s.dropped_odometry, s.dropped_invalid,
      s.rss_mb, s.alignment, s.degenerate > 0 ? fmt::format(" ({} of 6)", s.degenerate) : "", alarms);
}

}  // namespace hgg
