// What a frame costs the map: correspondence, fusion, a whole step; and the map file.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "alignment/correspondence.h"
#include "creation/object_graph.h"
#include "map/class_evidence.h"
#include "map/file.h"
#include "map/fuse.h"
#include "mapper.h"
#include "scan.h"

namespace hgg::map_bench {
namespace {

/// A mapper that has been once around the yard.
Mapper lapped() {
  Mapper mapper(Config{}, ClassTable::builtin());
  for (int k = 0; k < 40; ++k) {
    mapper.step(simulatedFrame(0.5 * k));
  }
  return mapper;
}

std::vector<ClassEvidence> evidenceOf(const LocalGraph& local, const Mapper& mapper, const Frame& frame) {
  const Config& config = mapper.config();
  return classEvidence(local, mapper.map(), frame.T_odom_body, 1, config.map.active_radius,
                       config.creation.sigma_floor);
}

void CoarseCorrespondence(benchmark::State& state) {
  const Mapper mapper = lapped();
  const Frame frame = simulatedFrame(20);
  const LocalGraph local = createLocalGraph(frame, frame.T_odom_body, mapper.classes(), mapper.config());
  for (auto _ : state) {
    benchmark::DoNotOptimize(coarseCorrespondence(local, mapper.map(), frame.T_odom_body, mapper.config()));
  }
}
BENCHMARK(CoarseCorrespondence)->Unit(benchmark::kMillisecond);

void Fuse(benchmark::State& state) {
  const Mapper mapper = lapped();
  const Frame frame = simulatedFrame(20);
  const LocalGraph local = createLocalGraph(frame, frame.T_odom_body, mapper.classes(), mapper.config());
  const auto pairs = coarseCorrespondence(local, mapper.map(), frame.T_odom_body, mapper.config());
  const auto evidence = evidenceOf(local, mapper, frame);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        fuse(mapper.map(), local, frame.T_odom_body, pairs, evidence, mapper.classes(), mapper.config()));
  }
}
BENCHMARK(Fuse)->Unit(benchmark::kMillisecond);

void Evidence(benchmark::State& state) {
  const Mapper mapper = lapped();
  const Frame frame = simulatedFrame(20);
  const LocalGraph local = createLocalGraph(frame, frame.T_odom_body, mapper.classes(), mapper.config());
  for (auto _ : state) {
    benchmark::DoNotOptimize(evidenceOf(local, mapper, frame));
  }
}
BENCHMARK(Evidence)->Unit(benchmark::kMillisecond);

void Step(benchmark::State& state) {
  Mapper mapper = lapped();
  Frame frame = simulatedFrame(20);
  for (auto _ : state) {
    benchmark::DoNotOptimize(mapper.step(frame));
    frame.utime_us += 100'000;
  }
}
BENCHMARK(Step)->Unit(benchmark::kMillisecond);

void SaveAndLoad(benchmark::State& state) {
  const Mapper mapper = lapped();
  const std::string path = (std::filesystem::temp_directory_path() / "hgg_bench.hgg").string();
  for (auto _ : state) {
    saveMap(mapper.map(), path);
    benchmark::DoNotOptimize(loadMap(path));
  }
  std::filesystem::remove(path);
}
BENCHMARK(SaveAndLoad)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::map_bench
