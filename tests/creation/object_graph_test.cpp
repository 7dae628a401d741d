#include "creation/object_graph.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "core/neighborhood.h"
#include "test_scene.h"

namespace hgg {
namespace {

LocalGraph create(const Frame& frame, const Pose& T_map_body = Pose::Identity()) {
  return createLocalGraph(frame, T_map_body, testClasses(), Config{});
}

/// A street: cars and poles in boxes of points over a road.
Frame street(unsigned seed) {
  std::mt19937 random(seed);
  Frame frame;
  frame.utime_us = 1234567;
  addBox(frame, random, 900, kCar, Vec3(10, 4, 0), Vec3(2, 0.9, 0.7));
  addBox(frame, random, 900, kCar, Vec3(18, 4, 0), Vec3(2, 0.9, 0.7));
  addBox(frame, random, 300, kPole, Vec3(14, -5, 2), Vec3(0.1, 0.1, 2));
  addBox(frame, random, 2000, kRoad, Vec3(10, 0, -1.5), Vec3(12, 8, 0.01));
  return frame;
}

TEST(CreateLocalGraph, NodesAreTheBeliefsOfTheirPoints) {
  Frame frame = street(1);
  std::vector<Vec3> pole;
  for (const Point& p : frame.points) {
    if (p.label == kPole) {
      pole.emplace_back(p.x, p.y, p.z);
    }
  }
  const LocalGraph graph = create(frame);
  EXPECT_EQ(graph.utime_us, 1234567);
  EXPECT_EQ(graph.points.size(), frame.points.size());
  int poles = 0, cars = 0;
  for (const LocalObject& object : graph.objects) {
    cars += object.label == kCar ? 1 : 0;
    if (object.label == kPole) {
      ++poles;
      const Belief expected = beliefFromPoints(pole);
      EXPECT_LE((object.belief.mean - expected.mean).norm(), 1e-9);
      EXPECT_LE((object.belief.cov - expected.cov).norm(), 1e-9);
      EXPECT_EQ(object.belief.kappa, 300);
    }
  }
  EXPECT_EQ(cars, 2);
  EXPECT_EQ(poles, 1);
}

TEST(CreateLocalGraph, LeavesOfEveryObjectMergeIntoItsBelief) {
  for (const LocalObject& object : create(street(2)).objects) {
    Belief merged;
    for (const LocalLeaf& leaf : object.leaves) {
      merged = merge(merged, transform(object.T_body_object, leaf));
    }
    EXPECT_EQ(merged.kappa, object.belief.kappa);
    EXPECT_LE((merged.mean - object.belief.mean).norm(), 1e-9);
    EXPECT_LE((merged.cov - object.belief.cov).norm(), 1e-9);
  }
}

TEST(CreateLocalGraph, OfNoPointsIsEmpty) {
  const LocalGraph graph = create({});
  EXPECT_TRUE(graph.objects.empty());
  EXPECT_TRUE(graph.edges.empty());
  EXPECT_EQ(graph.points.size(), 0U);
}

TEST(CreateLocalGraph, CountsWhatItDrops) {
  Frame frame = street(3);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  frame.points.push_back({nan, 0, 0, 0, kCar});
  frame.points.push_back({0.1F, 0, 0, 0, kCar});
  frame.points.push_back({500, 0, 0, 0, kCar});
  frame.points.push_back({5, 0, 0, 0, kUnlabeled});
  frame.points.push_back({5, 0, 0, 0, 4242});
  const LocalGraph graph = create(frame);
  EXPECT_EQ(graph.nonfinite_points, 1U);
  EXPECT_EQ(graph.out_of_range_points, 2U);
  EXPECT_EQ(graph.ignored_points, 1U);
  EXPECT_EQ(graph.unknown_labels, 1U);
  EXPECT_EQ(graph.points.size(), frame.points.size() - 5);
}

TEST(CreateLocalGraph, ThePredictedPoseMovesTilesAndNothingElse) {
  std::mt19937 random(4);
  const Frame frame = street(4);
  const LocalGraph here = create(frame), there = create(frame, randomPose(random, 50));
  const auto things = [](const LocalGraph& graph) {
    std::vector<LocalObject> list;
    std::copy_if(graph.objects.begin(), graph.objects.end(), std::back_inserter(list),
                 [](const LocalObject& o) { return !o.stuff; });
    return list;
  };
  const auto a = things(here), b = things(there);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].belief.mean, b[i].belief.mean);
    EXPECT_EQ(a[i].belief.cov, b[i].belief.cov);
    EXPECT_EQ(a[i].T_body_object.matrix(), b[i].T_body_object.matrix());
  }
}

/// S1 of the paper from Eigen's general solvers.
double geometryDistance(const Belief& a, const Belief& b, double sigma_floor) {
  const Mat3 floor = sigma_floor * sigma_floor * Mat3::Identity(), cov_a = a.cov + floor, cov_b = b.cov + floor;
  const Vec3 d = a.mean - b.mean;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat3> solver(cov_a, cov_b);
  return std::sqrt(d.dot((0.5 * (cov_a + cov_b)).inverse() * d)) +
         std::sqrt(solver.eigenvalues().array().log().square().sum());
}

TEST(ConnectObjects, WeightsEqualTheEquationAndLieInZeroToOne) {
  std::mt19937 random(5);
  for (const double share : {0.0, 0.3, 1.0}) {
    CreationConfig config;
    config.edge_geometry_share = share;
    std::vector<Belief> beliefs;
    std::vector<GraphNode> nodes;
    std::vector<Vec3> means;
    for (int k = 0; k < 60; ++k) {
      beliefs.push_back(randomBelief(random, 20));
    }
    for (const Belief& b : beliefs) {
      nodes.push_back({static_cast<ClassId>(below(random, 3)), &b});
      means.push_back(b.mean);
    }
    const std::vector<LocalEdge> edges = connectObjects(nodes, config);
    std::vector<std::pair<int, int>> pairs;
    double s1_max = 0;
    for (const LocalEdge& e : edges) {
      pairs.emplace_back(e.a, e.b);
      s1_max = std::max(s1_max, geometryDistance(beliefs[static_cast<std::size_t>(e.a)],
                                                 beliefs[static_cast<std::size_t>(e.b)], config.sigma_floor));
    }
    EXPECT_EQ(pairs, relativeNeighborhood(means));
    for (const LocalEdge& e : edges) {
      const auto a = static_cast<std::size_t>(e.a), b = static_cast<std::size_t>(e.b);
      const double s1 = geometryDistance(beliefs[a], beliefs[b], config.sigma_floor),
                   s2 = nodes[a].label == nodes[b].label ? 0 : 1;
      EXPECT_NEAR(e.weight, share * s1 / s1_max + (1 - share) * s2, 1e-9);
      EXPECT_GE(e.weight, 0);
      EXPECT_LE(e.weight, 1);
    }
  }
}

TEST(ConnectObjects, TakesNoNodesOneNodeAndCopiesOfANode) {
  const Belief point{Vec3(1, 2, 3), Mat3::Zero(), 1};
  EXPECT_TRUE(connectObjects({}, {}).empty());
  EXPECT_TRUE(connectObjects({{kCar, &point}}, {}).empty());
  const std::vector<LocalEdge> same = connectObjects({{kCar, &point}, {kCar, &point}}, {});
  ASSERT_EQ(same.size(), 1U);
  EXPECT_NEAR(same[0].weight, 0, 1e-9);
  CreationConfig config;
  config.edge_geometry_share = 0.3;
  const std::vector<LocalEdge> differ = connectObjects({{kCar, &point}, {kPole, &point}}, config);
  ASSERT_EQ(differ.size(), 1U);
  EXPECT_TRUE(differ[0].weight >= 0.7 - 1e-9 && differ[0].weight <= 1) << differ[0].weight;
}

}  // namespace
}  // namespace hgg
