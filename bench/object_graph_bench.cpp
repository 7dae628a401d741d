// What the object graph of a map costs: a frame, a closed loop and the frames after it, and from scratch.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>

#include "bus/codec.h"
#include "core/neighborhood.h"
#include "core/se3.h"
#include "mapper.h"
#include "publish/graph_update.h"

namespace hgg::object_graph_bench {
namespace {

using Random = std::mt19937;

constexpr int kNodesAKeyframe = 5;  // as on KITTI 05
constexpr EdgeModel kModel;

double normal(Random& random, double sigma) { return std::normal_distribution<double>(0, sigma)(random); }

MapNode nodeAt(Random& random, NodeId id, const Vec3& mean) {
  constexpr ClassId kLabels[] = {10, 80, 71};
  MapNode node;
  node.id = id;
  node.label = kLabels[random() % 3];
  node.belief = {mean, Vec3(0.4, 0.2, 0.3).asDiagonal().toDenseMatrix(), 500};
  addViews(node.classes, {{node.label, 1000.0F}});
  return node;
}

/// Nodes along streets 8 m apart, in rows of 250 keyframes.
Map mapOfStreets(Random& random, int nodes) {
  KeyframeGraph keyframes;
  std::vector<MapNode> all;
  for (int k = 0; static_cast<int>(all.size()) < nodes; ++k) {
    Pose T = Pose::Identity();
    T.translation() = Vec3(2 * (k % 250), 8 * (k / 250), 0);
    keyframes.add({k, T});
    for (int i = 0; i < kNodesAKeyframe; ++i) {
      const Vec3 mean = T * Vec3(normal(random, 5), normal(random, 5), normal(random, 1));
      all.push_back(nodeAt(random, static_cast<NodeId>(all.size()) + 1, mean));
      all.back().anchor = k;
    }
  }
  Map map = Map::restore(std::move(all), std::move(keyframes), {}, 1);
  map.setTileSize(Config{}.creation.tile_size);
  return map;
}

MapCorrection loopOver(Random& random, const Map& map) {
  MapCorrection correction;
  Vec3 drift = Vec3::Zero();
  for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
    drift += Vec3(normal(random, 0.01), normal(random, 0.01), normal(random, 0.001));
    Pose T = map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body;
    T.translation() += drift;
    correction.moved.emplace_back(k, T);
  }
  return correction;
}

/// A frame that moves the 200 nodes around the robot by centimetres, in a place of 1000, with so many elsewhere.
void GraphOfAFrame(benchmark::State& state) {
  Random random(1);
  constexpr int kMoving = 200, kAround = 1000;
  std::vector<Vec3> means;
  for (int k = 0; k < kAround; ++k) {
    means.emplace_back(normal(random, 40), normal(random, 40), normal(random, 1));
  }
  std::ranges::sort(means, {}, [](const Vec3& p) { return p.squaredNorm(); });
  for (std::int64_t k = 0; k < state.range(0); ++k) {
    const Vec3 street(1000 + 2.0 * static_cast<double>(k / 5 % 500), 8 * static_cast<double>(k / 2500), 0);
    means.push_back(street + Vec3(normal(random, 5), normal(random, 5), 0));
  }
  std::vector<MapNode> nodes;
  for (const Vec3& mean : means) {
    nodes.push_back(nodeAt(random, static_cast<NodeId>(nodes.size()) + 1, mean));
  }
  ObjectGraph graph;
  graph.setModel(kModel);
  for (const MapNode& node : nodes) {
    graph.put(node.id, node.label, node.belief);
  }
  graph.settle();
  const std::int64_t before = graph.computations();
  for (auto _ : state) {
    state.PauseTiming();
    for (int k = 0; k < kMoving; ++k) {
      nodes[static_cast<std::size_t>(k)].belief.mean += Vec3(normal(random, 0.01), normal(random, 0.01), 0);
    }
    state.ResumeTiming();
    for (int k = 0; k < kMoving; ++k) {
      const MapNode& node = nodes[static_cast<std::size_t>(k)];
      graph.put(node.id, node.label, node.belief);
    }
    benchmark::DoNotOptimize(graph.refresh(ObjectGraph::Postponed::kTakeSome));
  }
  state.counters["computed"] =
      static_cast<double>(graph.computations() - before) / static_cast<double>(state.iterations());
}
BENCHMARK(GraphOfAFrame)->Arg(0)->Arg(1000)->Arg(10000)->Arg(100000)->Unit(benchmark::kMicrosecond);

/// The correction itself, without and with an object graph.
void ApplyALoop(benchmark::State& state) {
  Random random(2);
  Map map = mapOfStreets(random, static_cast<int>(state.range(0)));
  if (state.range(1) != 0) {
    map.setEdgeModel(kModel);
  }
  for (auto _ : state) {
    state.PauseTiming();
    const MapCorrection correction = loopOver(random, map);
    map.settleGraph();
    state.ResumeTiming();
    benchmark::DoNotOptimize(map.apply(correction));
  }
}
BENCHMARK(ApplyALoop)->Args({20000, 0})->Args({20000, 1})->Unit(benchmark::kMillisecond)->Iterations(20);

/// A frame's share of the loop before it.
void FrameAfterALoop(benchmark::State& state) {
  Random random(3);
  Map map = mapOfStreets(random, static_cast<int>(state.range(0)));
  map.setEdgeModel(kModel);
  const std::int64_t before = map.graph().computations();
  for (auto _ : state) {
    if (map.graph().isSettled()) {
      state.PauseTiming();
      map.apply(loopOver(random, map));
      state.ResumeTiming();
    }
    benchmark::DoNotOptimize(map.apply(MapUpdate{}));
  }
  state.counters["computed"] =
      static_cast<double>(map.graph().computations() - before) / static_cast<double>(state.iterations());
}
BENCHMARK(FrameAfterALoop)->Arg(20000)->Unit(benchmark::kMillisecond);

/// What the frame that closes a loop pays for telling subscribers of it; the frames after it pay the same until all is
/// told.
void PublishALoop(benchmark::State& state) {
  Random random(4);
  const Mapper mapper(Config{}, ClassTable::builtin(), mapOfStreets(random, static_cast<int>(state.range(0))));
  StepReport report;
  for (const auto& [id, node] : mapper.map().nodes()) {
    report.delta.moved.push_back(id);
  }
  for (auto _ : state) {
    MoveQueue moves;
    benchmark::DoNotOptimize(encodeGraphUpdate(changedGraph(mapper, report, moves.next(report.delta))));
  }
}
BENCHMARK(PublishALoop)->Arg(20000)->Unit(benchmark::kMillisecond);

/// The edges alone of what is published.
void EdgesOfALoop(benchmark::State& state) {
  Random random(5);
  Map map = mapOfStreets(random, static_cast<int>(state.range(0)));
  map.setEdgeModel(kModel);
  std::vector<NodeId> ids;
  for (const auto& [id, node] : map.nodes()) {
    ids.push_back(id);
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(map.graph().edgesOf(ids));
  }
}
BENCHMARK(EdgesOfALoop)->Arg(200)->Arg(20000)->Unit(benchmark::kMicrosecond);

void GraphFromScratch(benchmark::State& state) {
  Random random(6);
  Map map = mapOfStreets(random, static_cast<int>(state.range(0)));
  for (auto _ : state) {
    map.setEdgeModel(kModel);
  }
}
BENCHMARK(GraphFromScratch)->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond);

/// The neighbourhood graph alone over a k-d tree, without what later updates need and without weights.
void StaticNeighborhood(benchmark::State& state) {
  Random random(6);
  const Map map = mapOfStreets(random, static_cast<int>(state.range(0)));
  std::vector<Vec3> means;
  for (const auto& [id, node] : map.nodes()) {
    means.push_back(node.belief.mean);
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(relativeNeighborhood(means));
  }
}
BENCHMARK(StaticNeighborhood)->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::object_graph_bench
