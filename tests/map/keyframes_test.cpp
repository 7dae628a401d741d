#include "map/keyframes.h"

#include <gtest/gtest.h>

#include <limits>
#include <tuple>

#include "random_geometry.h"

namespace hgg::keyframes_test {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

Pose at(double x, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(x, 0, 0);
  return T;
}

BetweenConstraint edge(KeyframeId a, KeyframeId b, double sigma, double sigma_turn = 0.001, double length = 2) {
  return {a, b, at(length), sigma, sigma_turn, false};
}

KeyframeGraph chainOf(int keyframes, double sigma = 0.02, double sigma_turn = 0.001) {
  KeyframeGraph graph;
  for (int k = 0; k < keyframes; ++k) {
    graph.add({k, at(2.0 * k)});
    if (k > 0) {
      graph.connect(edge(k - 1, k, sigma, sigma_turn));
    }
  }
  return graph;
}

KeyframeGraph randomGraph(std::mt19937& random, int keyframes, int edges) {
  KeyframeGraph graph;
  for (int k = 0; k < keyframes; ++k) {
    graph.add({k, randomPose(random, 20)});
  }
  for (int n = 0; n < edges; ++n) {
    const auto a = static_cast<KeyframeId>(below(random, static_cast<std::uint32_t>(keyframes)));
    const auto b = static_cast<KeyframeId>(below(random, static_cast<std::uint32_t>(keyframes)));
    if (a != b) {
      graph.connect(edge(a, b, uniform(random, 0.01, 0.3), uniform(random, 1e-4, 0.02), uniform(random, 0, 10)));
    }
  }
  return graph;
}

using Label = std::pair<double, double>;  // position, turn

/// Every keyframe asks its neighbours, all at once, until none has anything new to say.
std::vector<Drift> driftByRelaxation(const KeyframeGraph& graph, KeyframeId from, double reach) {
  const auto n = graph.poses().size();
  std::vector<Label> labels(n, {kFar, 0}), before;
  for (int sweep = 0; labels != before; ++sweep) {
    EXPECT_LT(sweep, 10000);
    before = labels;
    labels.assign(n, {kFar, 0});
    labels[static_cast<std::size_t>(from)] = {0, 0};
    for (const BetweenConstraint& e : graph.edges()) {
      for (const auto& [a, b] : {std::pair(e.a, e.b), std::pair(e.b, e.a)}) {
        const auto [position, turn] = before[static_cast<std::size_t>(a)];
        const Label label(std::hypot(position + turn * e.T_a_b.translation().norm(), e.sigma),
                          std::hypot(turn, e.sigma_turn));
        if (label.first < reach) {
          labels[static_cast<std::size_t>(b)] = std::min(labels[static_cast<std::size_t>(b)], label);
        }
      }
    }
  }
  std::vector<Drift> drift;
  for (const auto& [position, turn] : labels) {
    drift.push_back(position < kFar ? Drift{position, turn} : Drift{-1, 0});
  }
  return drift;
}

TEST(KeyframeGraph, DriftEqualsThatOfRelaxation) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    const int n = 1 + static_cast<int>(below(random, 14));
    const KeyframeGraph graph = randomGraph(random, n, static_cast<int>(below(random, 30)));
    const auto from = static_cast<KeyframeId>(below(random, static_cast<std::uint32_t>(n)));
    const double reach = run % 2 == 0 ? kFar : uniform(random, 0.1, 1);
    const auto drift = graph.driftFrom(from, reach), expected = driftByRelaxation(graph, from, reach);
    ASSERT_EQ(drift.size(), expected.size());
    for (std::size_t k = 0; k < drift.size(); ++k) {
      EXPECT_EQ(drift[k].position, expected[k].position) << "run " << run << ", keyframe " << k;
      EXPECT_EQ(drift[k].turn, expected[k].turn) << "run " << run << ", keyframe " << k;
    }
  }
}

TEST(KeyframeGraph, DriftGrowsAlongAChainFasterThanItsSteps) {
  const std::vector<Drift> drift = chainOf(100).driftFrom(99, kFar);
  EXPECT_EQ(drift[99].position, 0);
  EXPECT_EQ(drift[99].turn, 0);
  for (std::size_t k = 0; k < 99; ++k) {
    EXPECT_GT(drift[k].position, drift[k + 1].position);
    EXPECT_GT(drift[k].turn, drift[k + 1].turn);
  }
  EXPECT_GT(drift[0].position, 0.02 * std::sqrt(99.0));  // what the turn makes of the way comes on top
  EXPECT_NEAR(drift[0].turn, 0.001 * std::sqrt(99.0), 1e-12);
  EXPECT_EQ(drift[98].position, 0.02);
}

TEST(KeyframeGraph, ALoopBringsItsOtherEndNearerAndWhatLiesAroundIt) {
  KeyframeGraph graph = chainOf(100);
  const std::vector<Drift> before = graph.driftFrom(99, kFar);
  BetweenConstraint loop = edge(0, 99, 0.08, 0.005, 1);
  loop.is_loop = true;
  graph.connect(loop);
  const std::vector<Drift> after = graph.driftFrom(99, kFar);
  EXPECT_EQ(after[0].position, 0.08);
  EXPECT_LT(after[5].position, 0.5 * before[5].position);
  for (std::size_t k = 0; k < 100; ++k) {
    EXPECT_LE(after[k].position, before[k].position);
  }
  EXPECT_EQ(after[90].position, before[90].position);
}

TEST(KeyframeGraph, ReachCutsWhereDriftComesToIt) {
  const KeyframeGraph graph = chainOf(100);
  const std::vector<Drift> all = graph.driftFrom(50, kFar), some = graph.driftFrom(50, 0.1);
  for (std::size_t k = 0; k < 100; ++k) {
    EXPECT_EQ(some[k].position, all[k].position < 0.1 ? all[k].position : -1) << k;
  }
  EXPECT_LT(some[0].position, 0);
  EXPECT_GE(some[49].position, 0);
  // The reach itself is beyond reach.
  EXPECT_LT(graph.driftFrom(50, 0.02)[49].position, 0);
}

TEST(KeyframeGraph, WhatNothingTiesIsMarkedAtAnyReach) {
  KeyframeGraph graph = chainOf(3);
  graph.add({3, at(6)});
  graph.add({4, at(8)});
  graph.connect(edge(3, 4, 0.02));
  const std::vector<Drift> drift = graph.driftFrom(1, kFar);
  EXPECT_EQ(drift[1].position, 0);
  EXPECT_EQ(drift[0].position, 0.02);
  EXPECT_LT(drift[3].position, 0);
  EXPECT_LT(drift[4].position, 0);
  EXPECT_EQ(graph.driftFrom(4, kFar)[3].position, 0.02);
}

TEST(KeyframeGraph, OneKeyframeHasNotDriftedFromItself) {
  const std::vector<Drift> drift = chainOf(1).driftFrom(0, 0.5);
  ASSERT_EQ(drift.size(), 1U);
  EXPECT_EQ(drift[0].position, 0);
  EXPECT_EQ(drift[0].turn, 0);
}

TEST(KeyframeGraph, NeedsOneEveryTwoMetresOrTwentyDegrees) {
  KeyframeGraph graph;
  EXPECT_TRUE(graph.needsOne(Pose::Identity()));
  EXPECT_EQ(graph.last(), -1);
  std::mt19937 random(2);
  for (int run = 0; run < 100; ++run) {
    const Pose T = randomPose(random, 100);
    EXPECT_EQ(graph.add({run, T}), run);
    const Vec3 way = randomVector(random, 1).normalized();
    const auto moved = [&](double metres, double degrees) {
      Pose step = Pose::Identity();
      step.translation() = metres * way;
      step.linear() = Eigen::AngleAxisd(degrees * M_PI / 180, way).toRotationMatrix();
      return Pose(T * step);
    };
    EXPECT_FALSE(graph.needsOne(T));
    EXPECT_FALSE(graph.needsOne(moved(1.99, 19.9)));
    EXPECT_TRUE(graph.needsOne(moved(2.01, 0)));
    EXPECT_TRUE(graph.needsOne(moved(0, 20.1)));
    EXPECT_TRUE(graph.needsOne(moved(0, -20.1)));
    EXPECT_TRUE(graph.needsOne(moved(50, 180)));
  }
}

BetweenConstraint looseEdge(KeyframeId a, KeyframeId b) { return {a, b, at(2), kAnywhere, kAnyTurn, false}; }

/// Keyframes 0 1 2 - 3 4 5 - 6: the two gaps are tied loosely.
KeyframeGraph threeFragments() {
  KeyframeGraph graph;
  for (int k = 0; k < 7; ++k) {
    graph.add({k, at(2.0 * k)});
    if (k > 0) {
      graph.connect(k == 3 || k == 6 ? looseEdge(k - 1, k) : edge(k - 1, k, 0.02));
    }
  }
  return graph;
}

using Fragments = std::vector<KeyframeId>;

TEST(KeyframeGraph, AFragmentIsWhatHoldsTogetherNamedByItsOldestKeyframe) {
  EXPECT_EQ(chainOf(4).fragments(), (Fragments{0, 0, 0, 0}));
  EXPECT_EQ(threeFragments().fragments(), (Fragments{0, 0, 0, 3, 3, 3, 6}));
  EXPECT_TRUE(KeyframeGraph().fragments().empty());
}

TEST(KeyframeGraph, ALoopJoinsFragments) {
  KeyframeGraph graph = threeFragments();
  graph.connect({6, 4, at(1), 0.1, 0.01, true});
  EXPECT_EQ(graph.fragments(), (Fragments{0, 0, 0, 3, 3, 3, 3}));
  graph.connect({1, 6, at(1), 0.1, 0.01, true});
  EXPECT_EQ(graph.fragments(), (Fragments{0, 0, 0, 0, 0, 0, 0}));
}

TEST(KeyframeGraph, LooseningReachesTheConstraintsOfItsRangeAndNoLoops) {
  KeyframeGraph graph = chainOf(7);
  BetweenConstraint loop = edge(2, 4, 0.1, 0.01);
  loop.is_loop = true;
  graph.connect(loop);
  graph.loosen({2, 4, 5});
  for (const BetweenConstraint& e : graph.edges()) {
    const double factor = !e.is_loop && e.a >= 2 && e.b <= 4 ? 5 : 1;
    EXPECT_DOUBLE_EQ(e.sigma, factor * (e.is_loop ? 0.1 : 0.02)) << e.a << " to " << e.b;
    EXPECT_DOUBLE_EQ(e.sigma_turn, factor * (e.is_loop ? 0.01 : 0.001)) << e.a << " to " << e.b;
  }
}

TEST(KeyframeGraph, LooseningMakesDriftLarger) {
  KeyframeGraph graph = chainOf(7, 0.02, 1e-9);
  graph.loosen({2, 5, 10});
  EXPECT_NEAR(graph.driftFrom(6, kFar)[0].position, 0.02 * std::sqrt(3 + 3 * 100.0), 1e-6);
}

}  // namespace
}  // namespace hgg::keyframes_test
