// Creation, stage by stage, on a simulated 64-beam frame.
#include <benchmark/benchmark.h>

#include <random>

#include "core/neighborhood.h"
#include "creation/cluster.h"
#include "creation/geometry_graph.h"
#include "creation/object_graph.h"
#include "scan.h"

namespace hgg::creation_bench {
namespace {

std::vector<PackedPoint> packed(const Frame& frame) {
  std::vector<PackedPoint> points;
  for (const Point& p : frame.points) {
    points.emplace_back(p.x, p.y, p.z, 0.0F);
  }
  return points;
}

/// Every point of the frame as one class: the worst case for clustering.
void ClusterWholeFrame(benchmark::State& state) {
  const std::vector<PackedPoint> points = packed(simulatedFrame(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(clusterEuclidean(points, {0.5F, 0.0157F}));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK(ClusterWholeFrame)->Unit(benchmark::kMillisecond);

void PartitionWholeFrame(benchmark::State& state) {
  const std::vector<PackedPoint> points = packed(simulatedFrame(0));
  for (auto _ : state) {
    std::vector<PackedPoint> copy = points;
    benchmark::DoNotOptimize(partitionLeaves(copy, Pose::Identity(), 64, {1.0F, 0.0157F}));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK(PartitionWholeFrame)->Unit(benchmark::kMillisecond);

void RelativeNeighborhood(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Vec3> points;
  for (std::int64_t i = 0; i < state.range(0); ++i) {
    points.emplace_back(80 * unit(random), 80 * unit(random), 3 * unit(random));
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(relativeNeighborhood(points));
  }
}
BENCHMARK(RelativeNeighborhood)->Arg(20)->Arg(100)->Arg(500)->Arg(2000)->Arg(20000)->Unit(benchmark::kMicrosecond);

void CreateLocalGraph(benchmark::State& state) {
  const Frame frame = simulatedFrame(0);
  const Config config;
  const ClassTable classes = ClassTable::builtin();
  for (auto _ : state) {
    benchmark::DoNotOptimize(createLocalGraph(frame, frame.T_odom_body, classes, config));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frame.points.size()));
}
BENCHMARK(CreateLocalGraph)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::creation_bench
