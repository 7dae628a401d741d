#include "replay.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/progress_bar.h"
#include "map/page_keeper.h"

namespace hgg {
namespace {

struct ReplayOptions {
  std::string log, config, out = "out/replay";
};

void describeDamage(const LogLoss& loss) {
  if (loss.gaps > 0 || loss.tail_bytes > 0) {
    fmt::print("the log is damaged: {} bytes lost in {} gaps, {} bytes after the last whole event; the rest was read\n",
               loss.gap_bytes, loss.gaps, loss.tail_bytes);
  }
}

int replay(const ReplayOptions& o) {
  const std::atomic<bool>& stop = stopOnSignals();
  Result<LoadedConfig> loaded = loadConfig(o.config);
  if (!loaded) {
    return fail(loaded.error);
  }
  const Result<std::optional<Rig>> rig = takeRig(*loaded);
  if (!rig) {
    return fail(rig.error);
  }
  // Asked first, so that a mistyped name does not empty the results of an earlier replay.
  if (const auto log = LogReader::open(o.log); !log) {
    return fail(log.error);
  }
  Result<OutputDirectory> out = OutputDirectory::open(o.out);
  if (!out) {
    return fail(out.error);
  }
  PageKeeper keeper(out->path("pages.db"), loaded->config.memory.budget_mb, 0, PageKeeper::Patience::kWaits);
  Mapper mapper(loaded->config, loaded->classes, {}, LoopTiming::kFixed, keeper.store());
  const auto on_frame = [&](const StepReport& report, const FrameTiming& timing) {
    out->add(report, timing, mapper.map());
  };
  ProgressBar bar("replay");
  const auto on_progress = [&](double share, std::int64_t frames) {
    bar.show(share, fmt::format("{} frames", frames));
  };
  const Result<ReplayReport> report = replayLog(o.log, mapper, on_frame, on_progress, stop, *rig);
  bar.finish();
  if (!report) {
    out->discard();
    return fail(report.error);
  }
  mapper.finish();
  if (const std::string error = out->finish(mapper, report->counts); !error.empty()) {
    return fail(error);
  }
  summarise(mapper, report->counts, *out);
  describeDamage(report->loss);
  if (report->stopped) {
    fmt::print("stopped before the end of the log; what was read is kept\n");
  }
  return kDone;
}

}  // namespace

void addReplay(CLI::App& app, Action& action) {
  const auto o = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "Map an LCM log, deterministically and as fast as it goes");
  command->add_option("LOG", o->log, "LCM event log (lcm-logger, hgg-convert, hgg-sim)")->required();
  command->add_option("--config", o->config, "TOML config (default: built-in)");
  command->add_option("--out", o->out, "directory for map.hgg, trajectory.tum, stats.json")->capture_default_str();
  command->footer("Example:\n  hggmap replay drive.lcm --out maps/drive && hggmap info maps/drive/map.hgg");
  command->callback([o, &action] { action = [o] { return replay(*o); }; });
}

}  // namespace hgg
