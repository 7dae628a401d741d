#include "run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "cli/commands.h"
#include "core/units.h"
#include "leftovers.h"
#include "map/file.h"
#include "map/map_store.h"
#include "map/page_keeper.h"

namespace hgg {
namespace {

struct RunOptions {
  std::string config, lcm_url, map, out = "out/run";
  std::vector<double> start;  // x, y, yaw_deg
  bool resume = false, print_config = false;
};

/// The map to go on from, an empty one where none is named.
Result<Map> startingMap(const std::string& path, const LoadedConfig& loaded) {
  if (path.empty()) {
    return Result<Map>::ok({});
  }
  Result<StoredMap> stored = loadMap(path);
  if (!stored) {
    return Result<Map>::fail(stored.error);
  }
  if (const std::string why = explainMismatch(stored->map, loaded.config, loaded.classes); !why.empty()) {
    return Result<Map>::fail(fmt::format("{}: {}", path, why));
  }
  return Result<Map>::ok(std::move(stored->map));
}

/// The height of the keyframe nearest to a place, m; 0 where there is none.
double heightAt(const Map& map, double x, double y) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  const auto distance = [&](const TimedPose& k) {
    return (k.T_map_body.translation().head<2>() - Eigen::Vector2d(x, y)).norm();
  };
  const auto nearest = std::ranges::min_element(poses, {}, distance);
  return nearest == poses.end() ? 0 : nearest->T_map_body.translation().z();
}

/// What a run begins with.
struct Start {
  Map map;
  bool is_resumed = false;  // it goes on from the journal
};

Result<Start> startOf(const RunOptions& o, const LoadedConfig& loaded) {
  Result<Map> map = startingMap(o.resume ? lastMapIn(o.out) : o.map, loaded);
  const bool is_resumed = o.resume && map;
  if (o.resume && !map) {
    // A damaged journal must not keep a service from starting for ever: OutputDirectory moves it aside.
    spdlog::error("{}; going on from what was saved before", map.error);
    const std::string saved = o.out + "/map.hgg";
    map = startingMap(std::filesystem::exists(saved) ? saved : std::string(), loaded);
  }
  return map ? Result<Start>::ok({std::move(*map), is_resumed}) : Result<Start>::fail(map.error);
}

int run(const RunOptions& o) {
  const std::atomic<bool>& stop = stopOnSignals();
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
  const Result<std::optional<Rig>> rig = takeRig(*loaded);
  if (!rig) {
    return fail(rig.error);
  }
  Result<Start> start = startOf(o, *loaded);
  if (!start) {
    return fail(start.error);
  }
  Result<OutputDirectory> out = OutputDirectory::open(o.out, start->is_resumed);
  if (!out) {
    return fail(out.error);
  }
  const double journal_s = config.map.snapshot_s;
  PageKeeper keeper(out->path(journal_s > 0 ? kJournalFile : "pages.db"), config.memory.budget_mb, journal_s,
                    PageKeeper::Patience::kPrompt);
  Mapper mapper(config, loaded->classes, std::move(start->map), LoopTiming::kPrompt, keeper.store());
  mapper.trackChanges();
  if (!o.start.empty()) {
    Pose T_map_start = Pose::Identity();
    T_map_start.linear() = Eigen::AngleAxisd(o.start[2] * kDegree, Vec3::UnitZ()).toRotationMatrix();
    T_map_start.translation() << o.start[0], o.start[1], heightAt(mapper.map(), o.start[0], o.start[1]);
    mapper.startAt(T_map_start);
  }
  const auto on_frame = [&](const StepReport& report, const FrameTiming& timing) {
    out->add(report, timing, mapper.map());
    if (keeper.isDue(PageKeeper::Clock::now())) {
      keeper.write(mapper.takeChanges(keeper.needsAll()));
    }
  };
  const Result<RunCounts> counts = runLive(config, mapper, stop, on_frame, *rig);
  if (!counts) {
    out->discard();
    return fail(counts.error);
  }
  keeper.beginToSave();
  mapper.finish();
  if (const std::string error = out->finish(mapper, *counts); !error.empty()) {
    return fail(error);
  }
  keeper.discard();
  if (journal_s == 0) {
    removeMapStore(out->path(kJournalFile));  // of a run before, which this one went on from
  }
  summarise(mapper, *counts, *out);
  return kDone;
}

}  // namespace

void addRun(CLI::App& app, Action& action) {
  const auto o = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Map live from LCM until Ctrl-C, then save");
  command->add_option("--config", o->config, "TOML config (default: built-in, see --print-config)");
  command->add_option("--lcm-url", o->lcm_url, "LCM provider, overrides lcm.url of the config");
  CLI::Option* map = command->add_option("--map", o->map, "map.hgg to go on from: the place in it is recognised");
  command->add_option("--start", o->start, "where in --map the robot starts, m and degrees, when that is known")
      ->type_name("X,Y,YAW")
      ->delimiter(',')
      ->expected(3)
      ->needs(map);
  command
      ->add_flag("--resume", o->resume, "go on from what the last run into --out left, killed or not; else begin anew")
      ->excludes(map);
  command->add_option("--out", o->out, "directory for map.hgg, trajectory.tum, stats.json")->capture_default_str();
  command->add_flag("--print-config", o->print_config, "print the effective config with every key explained, and exit");
  command->footer(
      "Example:\n  hggmap run --config firmware_cfg/semantickitti/hggmap.toml --out maps/today\n"
      "  hggmap run --map maps/today/map.hgg                   # anywhere in the map: recognised in a few metres\n"
      "  hggmap run --map maps/today/map.hgg --start 2.5,-1,90 # known to about 0.3 m and 3 degrees\n"
      "  hggmap run --out maps/yard --resume                   # as a service: goes on after a crash or a reboot");
  command->callback([o, &action] { action = [o] { return run(*o); }; });
}

}  // namespace hgg
