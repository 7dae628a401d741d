// What aligning a frame costs as the map grows, far away and around the robot.
#include <benchmark/benchmark.h>

#include <random>

#include "alignment/align.h"
#include "alignment/propagation.h"
#include "creation/object_graph.h"
#include "mapper.h"
#include "scan.h"

namespace hgg::alignment_bench {
namespace {

/// Cars of twenty leaves each, spread over a disc around the map's origin.
std::vector<MapNode> carsAround(std::int64_t count, double inner_radius, double outer_radius) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<MapNode> cars;
  for (std::int64_t k = 0; k < count; ++k) {
    const double radius = std::sqrt(std::lerp(inner_radius * inner_radius, outer_radius * outer_radius, unit(random)));
    const double bearing = 2 * M_PI * unit(random);
    MapNode car;
    car.label = 10;
    car.belief = {Vec3(radius * std::cos(bearing), radius * std::sin(bearing), 0),
                  Vec3(1.5, 0.3, 0.2).asDiagonal().toDenseMatrix(), 1000};
    car.T_map_object.translation() = car.belief.mean;
    Leaves leaves;
    for (int leaf = 0; leaf < 20; ++leaf) {
      leaves.push_back(packLeaf({Vec3(0.2 * leaf - 2, 0, 0), 0.01 * Mat3::Identity(), 50}));
    }
    car.geometry = shareLeaves(std::move(leaves));
    cars.push_back(car);
  }
  return cars;
}

struct Case {
  Map map;
  LocalGraph local;
  PoseBelief prior;
  Config config;
};

/// A 118k-point frame, its odometry 3 cm and 0.2 degrees wrong, the map of a lap and `cars` beside it.
Case frameAgainst(std::vector<MapNode> cars) {
  Mapper mapper(Config{}, ClassTable::builtin());
  for (int k = 0; k < 40; ++k) {
    mapper.step(simulatedFrame(0.5 * k));
  }
  const Frame frame = simulatedFrame(20);
  Case c{mapper.map(), {}, {}, mapper.config()};
  MapUpdate update;
  update.created = std::move(cars);
  c.map.apply(std::move(update));
  Pose T_wrong = frame.T_odom_body;
  T_wrong.translation().x() += 0.03;
  T_wrong.rotate(Eigen::AngleAxisd(0.2 * M_PI / 180, Vec3::UnitZ()));
  Pose T_before = T_wrong;
  T_before.translation().x() -= 1;
  const Pose T_before_wrong = T_before.inverse() * T_wrong;
  c.prior = *propagatePose({T_before, 1e6 * Mat6::Identity()}, T_before_wrong,
                           odometryNoise(T_before_wrong, c.config.alignment));
  c.local = createLocalGraph(frame, T_wrong, mapper.classes(), c.config);
  return c;
}

void alignRepeatedly(benchmark::State& state, const Case& c) {
  std::size_t leaf_pairs = 0;
  for (auto _ : state) {
    leaf_pairs = align(c.local, c.map, c.prior, c.config).leaf_pairs;
  }
  state.counters["objects"] = static_cast<double>(c.map.nodes().size());
  state.counters["leaf_pairs"] = static_cast<double>(leaf_pairs);
}

/// Objects elsewhere: beyond the active radius, as dense as around the robot. Must cost nothing.
void AlignWithObjectsElsewhere(benchmark::State& state) {
  const double outer_radius = 200 + 5 * std::sqrt(static_cast<double>(state.range(0)));
  alignRepeatedly(state, frameAgainst(carsAround(state.range(0), 200, outer_radius)));
}
BENCHMARK(AlignWithObjectsElsewhere)
    ->Arg(0)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond);

/// Objects within the active radius: a colliding place.
void AlignWithObjectsAround(benchmark::State& state) {
  alignRepeatedly(state, frameAgainst(carsAround(state.range(0), 5, 95)));
}
BENCHMARK(AlignWithObjectsAround)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::alignment_bench
