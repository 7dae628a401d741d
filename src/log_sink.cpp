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
  sink.goal = [](const GoalReply& reply) {
    spdlog::info("query {} of '{}': {}", reply.request_id, reply.client, goalLine(reply));
  };
  return sink;
}

std::string goalLine(const GoalReply& reply) {
  static constexpr const char* kSaid[] = {"?", "ok", "ambiguous", "not found", "not understood", "failed"};
  std::string line = kSaid[static_cast<std::size_t>(reply.status)];
  if (!reply.answers.empty()) {
    const GoalAnswer& first = reply.answers.front();
    line += fmt::format(", {} {} ({:.0f} %)", first.name, first.id, 100 * first.probability);
  }
  if (reply.goal_kind != GoalKind::kNone) {
    line += fmt::format(", {:.1f} m to walk", reply.path_length);
  }
  for (const std::string& why : {reply.text, reply.goal_reason}) {
    line += why.empty() ? "" : "; " + why;
  }
  return line;
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
