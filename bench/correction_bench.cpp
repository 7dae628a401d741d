// What one window and one pose graph cost to solve, and what a closed loop costs the frame it is applied in.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "correction/pose_graph.h"
#include "correction/window.h"
#include "map/map.h"

namespace hgg::correction_bench {
namespace {

using Random = std::mt19937;

double normal(Random& random, double sigma) { return std::normal_distribution<double>(0, sigma)(random); }

Vec6 noise(Random& random, double sigma, double sigma_turn) {
  Vec6 xi;
  for (Eigen::Index k = 0; k < 6; ++k) {
    xi[k] = normal(random, k < 3 ? sigma : sigma_turn);
  }
  return xi;
}

/// Poses a metre apart among boxes, each seen from about six of them.
WindowProblem windowAmongObjects(int poses, int objects, int observations) {
  Random random(1);
  std::uniform_real_distribution<double> place(-20, 20), size(0.1, 1);
  WindowProblem problem;
  std::vector<Pose> truth(static_cast<std::size_t>(poses), Pose::Identity());
  for (int m = 0; m < poses; ++m) {
    Pose& T = truth[static_cast<std::size_t>(m)];
    T.translation().x() = m;
    problem.poses.push_back(m == 0 ? T : retract(T, noise(random, 0.05, 0.01)));
    if (m > 0) {
      const Pose T_a_b = truth[static_cast<std::size_t>(m) - 1].inverse() * T;
      problem.constraints.push_back({m - 1, m, retract(T_a_b, noise(random, 0.02, 0.005)), 0.02, 0.005, false});
    }
  }
  problem.oldest = {problem.poses[0], informationOf({0, 0, problem.poses[0], 0.01, 0.002, false})};
  std::vector<Belief> things;
  for (int i = 0; i < objects; ++i) {
    const Vec3 axes(size(random), size(random), size(random));
    things.push_back({Vec3(place(random), place(random), 0), axes.cwiseAbs2().asDiagonal().toDenseMatrix(), 500});
    Belief known = things.back();
    known.mean += noise(random, 0.05, 0).head<3>();
    problem.objects.push_back(i % 2 == 0 ? known : Belief{});
  }
  for (int k = 0; k < observations; ++k) {
    const int pose = static_cast<int>(random() % static_cast<unsigned>(poses)), object = k % objects;
    Belief seen = transform(truth[static_cast<std::size_t>(pose)].inverse(), things[static_cast<std::size_t>(object)]);
    seen.mean += noise(random, 0.05, 0).head<3>();
    seen.cov *= std::exp(normal(random, 0.2));
    if (k % 20 == 0) {
      seen.mean.x() += 3;  // of another object
    }
    problem.observations.push_back({pose, object, seen});
  }
  return problem;
}

void Window(benchmark::State& state) {
  const WindowProblem problem =
      windowAmongObjects(10, static_cast<int>(state.range(0)), 6 * static_cast<int>(state.range(0)));
  WindowConfig config;
  config.position_covariances = state.range(1) != 0;
  WindowSolution solution;
  for (auto _ : state) {
    solution = solveWindow(problem, config);
    benchmark::DoNotOptimize(solution);
  }
  state.counters["iterations"] = solution.iterations;
  state.counters["usable"] = solution.usable ? 1 : 0;
}
BENCHMARK(Window)->Args({10, 0})->Args({100, 0})->Args({100, 1})->Args({300, 0})->Unit(benchmark::kMillisecond);

/// A winding drive over a square kilometre, two metres a step, with drift; loops where it comes past itself, and if
/// asked for a false one to every fifty.
void PoseGraph(benchmark::State& state) {
  Random random(2);
  const auto count = static_cast<int>(state.range(0)), loops = count / 20;
  std::vector<Pose> truth{Pose::Identity()}, drifted{Pose::Identity()};
  std::vector<BetweenConstraint> edges;
  for (int k = 1; k < count; ++k) {
    // Turns back towards the middle when it gets far from it.
    const Pose& last = truth.back();
    const Vec3 home_body = last.linear().transpose() * -last.translation();
    const double pull = last.translation().norm() > 250 ? 0.05 * std::atan2(home_body.y(), home_body.x()) : 0;
    Pose T_a_b = Pose::Identity();
    T_a_b.linear() = Eigen::AngleAxisd(pull + normal(random, 0.1), Vec3::UnitZ()).toRotationMatrix();
    T_a_b.translation().x() = 2;
    const Pose measured = retract(T_a_b, noise(random, 0.02, 0.002));
    truth.push_back(last * T_a_b);
    drifted.push_back(drifted.back() * measured);
    edges.push_back({k - 1, k, measured, 0.02, 0.002, false});
  }
  int found = 0;
  for (int tries = 0; tries < 100000000 && found < loops; ++tries) {
    const int a = static_cast<int>(random() % static_cast<unsigned>(count)),
              b = static_cast<int>(random() % static_cast<unsigned>(count));
    const Pose &T_a = truth[static_cast<std::size_t>(a)], &T_b = truth[static_cast<std::size_t>(b)];
    if (b > a + 50 && (T_a.translation() - T_b.translation()).norm() < 5) {
      edges.push_back({a, b, retract(T_a.inverse() * T_b, noise(random, 0.1, 0.01)), 0.1, 0.01, true});
      ++found;
      if (found % 50 == 0 && state.range(1) != 0) {
        edges.push_back({a, (b + count / 2) % count, Pose::Identity(), 0.1, 0.01, true});  // a false one
      }
    }
  }
  PoseGraphSolution solution;
  for (auto _ : state) {
    solution = solvePoseGraph(drifted, edges);
    benchmark::DoNotOptimize(solution);
  }
  const auto error = [&](const std::vector<Pose>& poses) {
    double sum = 0;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      sum += (poses[k].translation() - truth[k].translation()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(poses.size()));
  };
  state.counters["loops"] = found;
  state.counters["iterations"] = solution.iterations;
  state.counters["converged"] = solution.converged ? 1 : 0;
  state.counters["error_before_m"] = error(drifted);
  state.counters["error_after_m"] = error(solution.poses);
  state.counters["believed"] = std::accumulate(solution.loop_weights.begin(), solution.loop_weights.end(), 0.0);
}
/// What a closed loop does to a frame: all nodes of a large map move with their keyframes. KITTI 05 has five to each.
void ApplyCorrection(benchmark::State& state) {
  Random random(3);
  const auto keyframes = static_cast<int>(state.range(0));
  KeyframeGraph graph;
  std::vector<MapNode> nodes;
  MapCorrection correction;
  for (int k = 0; k < keyframes; ++k) {
    Pose T = Pose::Identity();
    T.translation() = Vec3(2 * (k % 250), 8 * (k / 250), 0);
    graph.add({k, T});
    correction.moved.emplace_back(k, retract(T, noise(random, 0.3, 0.01)));
    for (int i = 0; i < state.range(1); ++i) {
      MapNode node;
      node.id = static_cast<NodeId>(nodes.size()) + 1;
      node.anchor = k;
      node.belief = {T * Vec3(normal(random, 5), normal(random, 5), 1), 0.1 * Mat3::Identity(), 100};
      node.geometry = shareLeaves(Leaves(5));
      nodes.push_back(node);
    }
  }
  Map map = Map::restore(std::move(nodes), std::move(graph), {}, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(map.apply(correction));
    state.PauseTiming();
    for (auto& [id, T] : correction.moved) {
      T = retract(T, noise(random, 0.02, 0.001));
    }
    state.ResumeTiming();
  }
}
/// What a new keyframe costs a robot that stays in one yard, all of whose keyframes are in reach: 50 to a round, each
/// tied to the one before it and to the one at its place in the first round.
void ReachInOneYard(benchmark::State& state) {
  const auto count = static_cast<KeyframeId>(state.range(0));
  KeyframeGraph graph;
  for (KeyframeId k = 0; k < count; ++k) {
    const double angle = 2 * M_PI * (k % 50) / 50;
    Pose T = Pose::Identity();
    T.translation() = 16 * Vec3(std::cos(angle), std::sin(angle), 0);
    graph.add({k, T});
    for (const KeyframeId a : {k - 1, k % 50}) {
      if (a >= 0 && a < k) {
        const Pose T_a_b = graph.poses()[static_cast<std::size_t>(a)].T_map_body.inverse() * T;
        graph.connect({a, k, T_a_b, 0.02, 0.0007, false});
      }
    }
  }
  std::size_t reached = 0;
  for (auto _ : state) {
    const std::vector<Drift> drift = graph.driftFrom(graph.last(), 0.5);
    reached = static_cast<std::size_t>(std::ranges::count_if(drift, [](const Drift& d) { return d.position >= 0; }));
  }
  state.counters["reached"] = static_cast<double>(reached);
  state.counters["map_mb"] = Map::restore({}, std::move(graph), {}, 1).megabytes();
}
BENCHMARK(ReachInOneYard)->Arg(10000)->Arg(50000)->Arg(300000)->Unit(benchmark::kMillisecond);

BENCHMARK(ApplyCorrection)->Args({1000, 5})->Args({10000, 5})->Args({10000, 10})->Unit(benchmark::kMillisecond);

BENCHMARK(PoseGraph)->Args({1000, 0})->Args({10000, 0})->Args({10000, 1})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hgg::correction_bench
