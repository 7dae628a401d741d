// What refining the leaves of one object costs: a 10 m tile of road, 20,000 points, leaves of all sizes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "correction/em.h"

namespace hgg::em_bench {
namespace {

constexpr double kTile = 10;  // m
constexpr int kPoints = 20000;
constexpr std::size_t kLeaves = 500;

Belief patch(const Vec3& centre, double side) {
  return {centre, Vec3(side * side / 12, side * side / 12, 4e-4).asDiagonal().toDenseMatrix(), 40 * side};
}

/// Leaves that lie side by side: squares of 10 m cut in four, any of them next, until there are enough; 0.1 m .. 5 m.
std::vector<Belief> leavesSideBySide(std::mt19937& random) {
  std::vector<Belief> leaves{patch(Vec3::Zero(), kTile)};
  while (leaves.size() < kLeaves) {
    Belief& cut = leaves[random() % leaves.size()];
    const double side = std::sqrt(12 * cut.cov(0, 0));
    if (side < 0.2) {
      continue;
    }
    const Vec3 centre = cut.mean;
    cut = patch(centre + side / 4 * Vec3(-1, -1, 0), side / 2);
    leaves.push_back(patch(centre + side / 4 * Vec3(-1, 1, 0), side / 2));
    leaves.push_back(patch(centre + side / 4 * Vec3(1, -1, 0), side / 2));
    leaves.push_back(patch(centre + side / 4 * Vec3(1, 1, 0), side / 2));
  }
  return leaves;
}

/// Leaves anywhere, sizes log-uniform in 0.1 m .. 5 m: each place is covered some fifteen times.
std::vector<Belief> leavesInLayers(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Belief> leaves;
  while (leaves.size() < kLeaves) {
    const Vec3 centre(kTile * (unit(random) - 0.5), kTile * (unit(random) - 0.5), 0);
    leaves.push_back(patch(centre, 0.1 * std::pow(50, unit(random))));
  }
  return leaves;
}

std::vector<Vec3> roadPoints(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> noise(0, 0.02);
  std::vector<Vec3> points;
  for (int i = 0; i < kPoints; ++i) {
    points.emplace_back(kTile * (unit(random) - 0.5), kTile * (unit(random) - 0.5), noise(random));
  }
  return points;
}

void refineRepeatedly(benchmark::State& state, std::vector<Belief> (*leavesOf)(std::mt19937&)) {
  std::mt19937 random(1);
  const std::vector<Belief> leaves = leavesOf(random);
  const std::vector<Vec3> points = roadPoints(random);
  EmOptions options;
  options.iterations = static_cast<int>(state.range(0));
  double explained = 0;
  for (auto _ : state) {
    explained = refineLeaves(leaves, leaves, points, options).explained;
  }
  state.counters["explained"] = explained;
  state.counters["pairs"] = static_cast<double>(findSight(leaves, points, options).leaf.size());
}

void RefineLeavesSideBySide(benchmark::State& state) { refineRepeatedly(state, leavesSideBySide); }
BENCHMARK(RefineLeavesSideBySide)->Arg(1)->Arg(3)->Arg(11)->Unit(benchmark::kMillisecond);

void RefineLeavesInLayers(benchmark::State& state) { refineRepeatedly(state, leavesInLayers); }
BENCHMARK(RefineLeavesInLayers)->Arg(1)->Arg(3)->Arg(11)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::em_bench
