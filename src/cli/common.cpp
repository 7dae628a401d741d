#include "cli/common.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/text.h"

namespace hgg {
namespace {

std::atomic<bool> g_stop{false};  // a signal handler can reach nothing else

}  // namespace

int fail(const std::string& error) {
  fmt::print(stderr, "hggmap: {}\n", error);
  return kBadInput;
}

int answerLines(const std::string& path, const std::string& form,
                const std::function<std::optional<std::string>(const nlohmann::json&)>& answer,
                const std::function<std::string(const std::string& why)>& refuse) {
  const std::optional<std::string> text = readFile(path);
  if (!text) {
    return fail(fmt::format("{}: cannot read the batch", path));
  }
  std::istringstream lines(*text);
  int number = 0, code = kDone;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const std::optional<std::string> answered = answer(nlohmann::json::parse(line, nullptr, false));
    if (!answered) {
      code = fail(fmt::format("{}:{}: a line is {}", path, number, form));
    }
    fmt::print("{}\n", answered ? *answered : refuse(fmt::format("a line is {}", form)));
    std::fflush(stdout);  // whoever stops it keeps what was answered
  }
  return code;
}

std::optional<std::vector<double>> numbersOf(const nlohmann::json& object, const char* key) {
  const auto it = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || it == object.end() || !it->is_array() || !std::ranges::all_of(*it, [](const auto& v) {
        return v.is_number() && std::isfinite(v.template get<double>());
      })) {
    return std::nullopt;
  }
  return it->get<std::vector<double>>();
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
  for (const auto& [cause, clouds] : drops.causes) {
    fmt::print("  {} clouds dropped: {}\n", clouds, cause);
  }
  if (drops.odometry > 0 && counts.odometry_interval_us > 0) {
    fmt::print("  odometry comes every {:.3g} s\n", static_cast<double>(counts.odometry_interval_us) * 1e-6);
  }
  if (counts.odometry_gap_us > 0) {
    fmt::print("  odometry has gaps of up to {:.2f} s; frame.odometry_gap_s says how long a gap is bridged\n",
               static_cast<double>(counts.odometry_gap_us) * 1e-6);
  }
  for (const auto& [reason, messages] : counts.decode_errors) {
    fmt::print("  {} messages unreadable: {}\n", messages, reason);
  }
  if (counts.odometry_rejected > 0) {
    fmt::print("  {} odometry samples rejected: {} with stamps out of line, the others late or twice\n",
               counts.odometry_rejected, counts.odometry_outliers);
  }
  if (counts.odometry_anew > 0) {
    fmt::print("  the odometry began anew {} times (its clock went back, or it paused)\n", counts.odometry_anew);
  }
  for (const auto& [trouble, times] : counts.rig ? counts.rig->troubles : std::map<std::string, std::int64_t>()) {
    fmt::print("  {} times {}\n", times, trouble);
  }
  if (counts.rig && counts.rig->labels.points > 0 && counts.rig->labels.labelled == 0) {
    fmt::print("  no point got a class from any camera: the map has no objects (see docs/rig.md)\n");
  }
  for (const std::string& line : counts.oddities) {
    fmt::print("  {}\n", line);
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
