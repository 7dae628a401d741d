// The grid around the robot beside mapping: what an update costs, what making the grid anew costs, and what publishing
// it costs the frames. Needs a log with true-sized clouds:
//   HGG_BENCH_LOG=kitti_0001.lcm HGG_BENCH_CONFIG=firmware_cfg/semantickitti/hggmap.toml hgg_bench
//   --benchmark_filter=LiveGrid
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "bus/codec.h"
#include "publish/publisher.h"
#include "replay.h"
#include "traversability/leaf_copy.h"
#include "traversability/live_grid.h"

namespace hgg::live_grid_bench {
namespace {

constexpr double kHalf = 20, kStep = 2;  // m

/// Of this thread's work, ms: what else the machine does is no part of it.
double cpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values.empty() ? 0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Maps the log with a mapper that is made for it, and calls visit(report, timing) after each frame. False when it
/// cannot.
template <typename Visit>
bool drive(benchmark::State& state, std::optional<Mapper>& mapper, Visit visit) {
  const char* log = std::getenv("HGG_BENCH_LOG");
  const char* file = std::getenv("HGG_BENCH_CONFIG");
  const Result<LoadedConfig> config = loadConfig(file == nullptr ? "" : file);
  if (log == nullptr || !config) {
    state.SkipWithError(log == nullptr ? "HGG_BENCH_LOG names no log" : config.error.c_str());
    return false;
  }
  mapper.emplace(config->config, config->classes);
  const std::atomic<bool> stop{false};
  const auto report = replayLog(log, *mapper, visit, nullptr, stop);
  if (!report) {
    state.SkipWithError(report.error.c_str());
  }
  return static_cast<bool>(report);
}

/// At every frame or at every so many, all at once or in turns. The grid is made anew at every tenth update.
void LiveGridUpdate(benchmark::State& state) {
  constexpr std::size_t kAnew = 10;
  for (auto _ : state) {
    std::optional<Mapper> mapper;
    std::optional<LiveGrid> live;
    std::vector<NodeId> touched;
    LeafCopy copy;
    std::vector<double> copy_ms, update_ms, anew_ms, columns, judged;
    std::int64_t frame = 0;
    const auto visit = [&](const StepReport& step, const FrameTiming&) {
      for (const auto* ids : {&step.delta.changed, &step.delta.moved, &step.delta.removed}) {
        touched.insert(touched.end(), ids->begin(), ids->end());
      }
      if (frame++ % state.range(0) != 0) {
        return;
      }
      const TraversabilityConfig& limits = mapper->config().traversability;
      const double x = kStep * std::round(step.T_map_body.translation().x() / kStep);
      const double y = kStep * std::round(step.T_map_body.translation().y() / kStep);
      const GridShape window = *gridShape({x - kHalf, y - kHalf, x + kHalf, y + kHalf}, limits.resolution);
      const double start = cpuMs();
      std::ranges::sort(touched);
      touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
      LeafChanges changes = live ? changesOf(mapper->map(), touched) : allOf(mapper->map());
      touched.clear();
      copy_ms.push_back(cpuMs() - start);
      live = live ? std::move(live) : LiveGrid(limits, static_cast<int>(state.range(1)));
      const double copied = cpuMs();
      copy.apply(std::move(changes));
      live->update(copy.leaves(), window, step.T_map_body.translation().head<2>());
      update_ms.push_back(cpuMs() - copied);
      columns.push_back(static_cast<double>(live->work().columns));
      judged.push_back(static_cast<double>(live->work().judged));
      if (update_ms.size() % kAnew == 1) {
        const double anew = cpuMs();
        benchmark::DoNotOptimize(buildCostGrid(copy.leaves(), window, limits));
        anew_ms.push_back(cpuMs() - anew);
      }
    };
    if (!drive(state, mapper, visit)) {
      return;
    }
    state.counters["update_ms_p50"] = quantile(update_ms, 0.5),
    state.counters["update_ms_p90"] = quantile(update_ms, 0.9);
    state.counters["copy_ms_p50"] = quantile(copy_ms, 0.5), state.counters["copy_ms_max"] = quantile(copy_ms, 1);
    state.counters["anew_ms_p50"] = quantile(anew_ms, 0.5);
    state.counters["columns_p50"] = quantile(columns, 0.5), state.counters["judged_p50"] = quantile(judged, 0.5);
  }
}
BENCHMARK(LiveGridUpdate)->Args({1, 64})->Args({1, 1})->Args({10, 1})->Iterations(1)->Unit(benchmark::kSecond);

/// Frames with and without the grid being published while the log is mapped as fast as it goes: as
/// busy as it can get.
void LiveGridBesideFrames(benchmark::State& state) {
  const bool publishes = state.range(0) != 0;
  for (auto _ : state) {
    std::optional<Mapper> mapper;
    std::optional<Publisher> publisher;
    std::vector<double> frame_ms;
    std::size_t grids = 0, bytes = 0;
    const auto visit = [&](const StepReport& step, const FrameTiming& timing) {
      const auto start = std::chrono::steady_clock::now();
      if (publishes && !publisher) {
        Sink sink;
        sink.ground = [&](const GroundGrid& grid) {
          ++grids;
          for (const auto& message : encodeTraversability(grid)) {
            bytes += message.size();
          }
        };
        publisher.emplace(*mapper, std::vector<Sink>{sink}, [] {
          return std::chrono::duration_cast<std::chrono::microseconds>(
                     std::chrono::steady_clock::now().time_since_epoch())
              .count();
        });
      }
      if (publisher) {
        publisher->publishFrame(step, timing);
        publisher->tick({});
      }
      frame_ms.push_back(timing.frame_ms +
                         std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    };
    if (!drive(state, mapper, visit)) {
      return;
    }
    state.counters["frame_ms_p50"] = quantile(frame_ms, 0.5), state.counters["frame_ms_p99"] = quantile(frame_ms, 0.99);
    state.counters["grids"] = static_cast<double>(grids);
    state.counters["kB_a_grid"] = grids == 0 ? 0 : static_cast<double>(bytes) * 1e-3 / static_cast<double>(grids);
  }
}
BENCHMARK(LiveGridBesideFrames)->Arg(0)->Arg(1)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace hgg::live_grid_bench
