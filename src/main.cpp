// hggmap: subcommands only. Exit 0 = done, 1 = the answer is no, 2 = bad input or usage.
#include <fmt/format.h>
#include <glog/logging.h>
#include <malloc.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "bus/log.h"
#include "core/units.h"
#include "map/export.h"
#include "map/file.h"
#include "mapper.h"
#include "output.h"
#include "place/zero_shot.h"
#include "progress_bar.h"
#include "replay.h"
#include "run.h"

namespace hgg {
namespace {

constexpr int kDone = 0, kNo = 1, kBadInput = 2;

std::atomic<bool> g_stop{false};  // a signal handler can reach nothing else

/// First Ctrl-C ends the work and keeps what there is; a second one kills.
void stopOnSignals() {
  const auto handler = [](int signal) {
    g_stop = true;
    std::signal(signal, SIG_DFL);
  };
  std::signal(SIGINT, handler);
  std::signal(SIGTERM, handler);
  std::signal(SIGHUP, handler);  // a dropped terminal session must not cost the map
}

int fail(const std::string& error) {
  fmt::print(stderr, "hggmap: {}\n", error);
  return kBadInput;
}

struct Options {
  std::string config, lcm_url, log, map, out, format, map_b, classes;
  std::string run_directory = "out/run", replay_directory = "out/replay";
  bool print_config = false, json = false;
};

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

int replay(const Options& o) {
  stopOnSignals();
  Result<LoadedConfig> loaded = loadConfig(o.config);
  if (!loaded) {
    return fail(loaded.error);
  }
  // Asked first, so that a mistyped name does not empty the results of an earlier replay.
  if (const auto log = LogReader::open(o.log); !log) {
    return fail(log.error);
  }
  Result<OutputDirectory> out = OutputDirectory::open(o.replay_directory);
  if (!out) {
    return fail(out.error);
  }
  Mapper mapper(loaded->config, loaded->classes);
  const auto on_frame = [&](const StepReport& report, const FrameTiming& timing) {
    out->add(report, timing, mapper.map());
  };
  ProgressBar bar("replay");
  const auto on_progress = [&](double share, std::int64_t frames) {
    bar.show(share, fmt::format("{} frames", frames));
  };
  const Result<ReplayReport> report = replayLog(o.log, mapper, on_frame, on_progress, g_stop);
  bar.finish();
  if (!report) {
    return fail(report.error);
  }
  mapper.finish();
  if (const std::string error = out->finish(mapper, report->counts); !error.empty()) {
    return fail(error);
  }
  summarise(mapper, report->counts, *out);
  if (const LogLoss& loss = report->loss; loss.gaps > 0 || loss.tail_bytes > 0) {
    fmt::print("the log is damaged: {} bytes lost in {} gaps, {} bytes after the last whole event; the rest was read\n",
               loss.gap_bytes, loss.gaps, loss.tail_bytes);
  }
  if (report->stopped) {
    fmt::print("stopped before the end of the log; what was read is kept\n");
  }
  return kDone;
}

int run(const Options& o) {
  stopOnSignals();
  Result<LoadedConfig> loaded = loadConfig(o.config);
  if (!loaded) {
    return fail(loaded.error);
  }
  Config& config = loaded->config;
  if (!o.lcm_url.empty()) {
    config.lcm.url = o.lcm_url;
  }
  if (o.print_config) {
    fmt::print("{}", printConfig(config));
    return kDone;
  }
  Map map;
  if (!o.map.empty()) {
    Result<StoredMap> stored = loadMap(o.map);
    if (!stored) {
      return fail(stored.error);
    }
    map = std::move(stored->map);
    if (const std::string why = explainMismatch(map, config, loaded->classes); !why.empty()) {
      return fail(fmt::format("{}: {}", o.map, why));
    }
  }
  Result<OutputDirectory> out = OutputDirectory::open(o.run_directory);
  if (!out) {
    return fail(out.error);
  }
  Mapper mapper(config, loaded->classes, std::move(map), LoopTiming::kPrompt);
  const auto on_frame = [&](const StepReport& report, const FrameTiming& timing) {
    out->add(report, timing, mapper.map());
  };
  const Result<RunCounts> counts = runLive(config, mapper, g_stop, on_frame);
  if (!counts) {
    return fail(counts.error);
  }
  mapper.finish();
  if (const std::string error = out->finish(mapper, *counts); !error.empty()) {
    return fail(error);
  }
  summarise(mapper, *counts, *out);
  return kDone;
}

int exportMap(const Options& o) {
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  std::ofstream file(o.out, std::ios::binary | std::ios::trunc);
  if (!(file << (o.format == "ply" ? exportPly(*stored) : exportJson(*stored))) || !file.flush()) {
    return fail(fmt::format("{}: cannot write the export", o.out));
  }
  return kDone;
}

int info(const Options& o) {
  const Result<StoredMap> stored = loadMap(o.map);
  if (!stored) {
    return fail(stored.error);
  }
  const Map& map = stored->map;
  struct Row {
    std::size_t nodes = 0, leaves = 0;
    double kappa = 0;
    bool stuff = false;
  };
  std::map<ClassId, Row> rows;
  Eigen::AlignedBox3d box;
  for (const auto& [id, node] : map.nodes()) {
    if (!isConfirmed(node)) {
      continue;
    }
    Row& row = rows[node.label];
    ++row.nodes, row.leaves += node.leaves.size(), row.kappa += node.belief.kappa, row.stuff = node.stuff;
    box.extend(node.belief.mean);
  }
  fmt::print(
      "{}: {} objects (and {} candidates), {} leaves, {} edges, {} keyframes, revision {}, {:.1f} MB in memory\n",
      o.map, map.confirmedCount(), map.nodes().size() - map.confirmedCount(), map.leafCount(), stored->edges.size(),
      map.keyframes().poses().size(), map.revision(), map.megabytes());
  if (!map.keyframes().poses().empty()) {
    fmt::print("time  {:.3f} .. {:.3f} s\n", static_cast<double>(map.keyframes().poses().front().utime_us) * 1e-6,
               static_cast<double>(map.keyframes().poses().back().utime_us) * 1e-6);
  }
  if (!box.isEmpty()) {
    fmt::print("means x {:.1f} .. {:.1f}, y {:.1f} .. {:.1f}, z {:.1f} .. {:.1f} m\n", box.min().x(), box.max().x(),
               box.min().y(), box.max().y(), box.min().z(), box.max().z());
  }
  fmt::print("{:>6}  {:<20} {:<6} {:>8} {:>8} {:>12}\n", "label", "class", "kind", "nodes", "leaves", "points");
  for (const auto& [label, row] : rows) {
    const auto name = map.classNames().find(label);
    fmt::print("{:>6}  {:<20} {:<6} {:>8} {:>8} {:>12.0f}\n", label,
               name != map.classNames().end() ? name->second : "?", row.stuff ? "stuff" : "thing", row.nodes,
               row.leaves, row.kappa);
  }
  return kDone;
}

/// The answer of align as one line of JSON; `ms` is the only thing in it that is not the same every time.
std::string alignmentJson(const ZeroShot& z, double ms) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index k = 0; k < 12; ++k) {
    rows.push_back(z.T_a_b.matrix()(k / 4, k % 4));
  }
  const PlaceEvidence& e = z.evidence;
  const nlohmann::ordered_json evidence{{"things_matched", e.things_matched},
                                        {"things_missed", e.things_missed},
                                        {"thing_share", e.thing_share},
                                        {"thing_odds", e.thing_odds},
                                        {"overlap", e.overlap},
                                        {"surface_share", e.surface_share},
                                        {"chance_share", e.chance_share},
                                        {"surface_odds", e.surface_odds},
                                        {"runner_up", z.runner_up}};
  const nlohmann::ordered_json answer{
      {"accepted", z.accepted}, {"T_a_b", rows},      {"score", z.score},     {"threshold", z.threshold},
      {"pairs", z.pairs},       {"reason", z.reason}, {"evidence", evidence}, {"ms", std::round(10 * ms) / 10}};
  return answer.dump();
}

std::string describe(const ZeroShot& z) {
  const Vec3 t = z.T_a_b.translation();
  const double yaw = std::atan2(z.T_a_b.linear()(1, 0), z.T_a_b.linear()(0, 0));
  const double tilt = std::acos(std::clamp(z.T_a_b.linear()(2, 2), -1.0, 1.0));
  return fmt::format(
      "{}: {}\nscore {:.1f}, threshold {:.1f}, best place elsewhere {:.1f}\n"
      "T_a_b: x {:.3f} y {:.3f} z {:.3f} m, yaw {:.2f} deg, tilt {:.2f} deg; {} pairs of things (--json lists them)",
      z.accepted ? "accepted" : "refused", z.reason, z.score, z.threshold, z.runner_up, t.x(), t.y(), t.z(),
      yaw / kDegree, tilt / kDegree, z.pairs.size());
}

int alignStored(const Options& o) {
  const Result<StoredMap> a = loadMap(o.map), b = loadMap(o.map_b);
  if (!a || !b) {
    return fail(!a ? a.error : b.error);
  }
  std::vector<SimilarClasses> similar;
  if (!o.classes.empty()) {
    const Result<ClassTable> classes = ClassTable::load(o.classes);
    if (!classes) {
      return fail(classes.error);
    }
    similar = classes->similar();
  }
  const auto begin = std::chrono::steady_clock::now();
  const ZeroShot found = alignMaps(a->map, b->map, similar);
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  const std::string answer = (o.json ? alignmentJson(found, ms) : describe(found)) + "\n";
  if (std::fputs(answer.c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    return fail("stdout: cannot write the answer");
  }
  return found.accepted ? kDone : kNo;
}

/// Defines the command line; `action` is set to the chosen subcommand's function.
void defineCommands(CLI::App& app, Options& o, std::function<int()>& action) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "hggmap 0.1.0");
  app.footer("Exit status: 0 done, 1 the answer is no, 2 bad input or usage.");

  CLI::App* live = app.add_subcommand("run", "Map live from LCM until Ctrl-C, then save");
  live->add_option("--config", o.config, "TOML config (default: built-in, see --print-config)");
  live->add_option("--lcm-url", o.lcm_url, "LCM provider, overrides lcm.url of the config");
  live->add_option("--map", o.map, "map.hgg to go on from");
  live->add_option("--out", o.run_directory, "directory for map.hgg, trajectory.tum, stats.json")
      ->capture_default_str();
  live->add_flag("--print-config", o.print_config, "print the effective config with every key explained, and exit");
  live->footer("Example:\n  hggmap run --config firmware_cfg/semantickitti/hggmap.toml --out maps/today");
  live->callback([&] { action = [&] { return run(o); }; });

  CLI::App* offline = app.add_subcommand("replay", "Map an LCM log, deterministically and as fast as it goes");
  offline->add_option("LOG", o.log, "LCM event log (lcm-logger, hgg-convert, hgg-sim)")->required();
  offline->add_option("--config", o.config, "TOML config (default: built-in)");
  offline->add_option("--out", o.replay_directory, "directory for map.hgg, trajectory.tum, stats.json")
      ->capture_default_str();
  offline->footer("Example:\n  hggmap replay drive.lcm --out maps/drive && hggmap info maps/drive/map.hgg");
  offline->callback([&] { action = [&] { return replay(o); }; });

  CLI::App* exporter = app.add_subcommand("export", "Write a map in another format");
  exporter->add_option("MAP", o.map, "map.hgg")->required();
  exporter->add_option("--format", o.format, "json: graph with geometry; ply: one vertex a leaf Gaussian")
      ->required()
      ->check(CLI::IsMember({"json", "ply"}));
  exporter->add_option("-o,--output", o.out, "file to write")->required();
  exporter->footer("Example:\n  hggmap export maps/drive/map.hgg --format json -o drive.json");
  exporter->callback([&] { action = [&] { return exportMap(o); }; });

  CLI::App* aligner = app.add_subcommand("align", "Lay one map over another, without any initial pose");
  aligner->add_option("A", o.map, "map.hgg whose frame is kept")->required();
  aligner->add_option("B", o.map_b, "map.hgg to lay over it")->required();
  aligner->add_flag("--json", o.json, "one line of JSON: accepted, T_a_b, score, threshold, pairs, reason");
  aligner->add_option("--classes", o.classes, "class table whose [[similar]] entries say which classes may be one");
  aligner->footer(
      "Exit status: 0 accepted, 1 refused, 2 bad input. T_a_b takes coordinates of B to those of A.\n"
      "Example:\n  hggmap align maps/monday/map.hgg maps/friday/map.hgg --json");
  aligner->callback([&] { action = [&] { return alignStored(o); }; });

  CLI::App* information = app.add_subcommand("info", "Say what is in a map");
  information->add_option("MAP", o.map, "map.hgg")->required();
  information->footer("Example:\n  hggmap info maps/drive/map.hgg");
  information->callback([&] { action = [&] { return info(o); }; });
}

}  // namespace
}  // namespace hgg

int main(int argc, char** argv) {
  // Clouds come and go ten times a second: keep their pages instead of giving them back and faulting them in again,
  // which costs 2 ms a frame.
  mallopt(M_TRIM_THRESHOLD, 128 << 20);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres speaks to users of its own; ours learn what came of it
  spdlog::set_default_logger(spdlog::stderr_color_mt("hggmap"));
  spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  CLI::App app("hggmap: LiDAR and odometry in, a probabilistic scene graph out", "hggmap");
  hgg::Options options;
  std::function<int()> action;
  hgg::defineCommands(app, options, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : hgg::fail(std::string(e.what()) + " (see --help)");
  }
  return action();
}
