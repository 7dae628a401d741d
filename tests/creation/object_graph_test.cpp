#include "creation/object_graph.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/neighborhood.h"
#include "test_scene.h"

namespace hgg::object_graph_test {
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

TEST(CreateLocalGraph, ConnectsTheObjectsByTheirRelativeNeighborhood) {
  std::mt19937 random(5);
  Frame frame;
  for (int k = 0; k < 30; ++k) {
    const Vec3 centre(3.0 * (k % 6) - 20, 4.0 * (k / 6) + uniform(random, -0.5, 0.5), 0);
    addBox(frame, random, 100, k % 2 == 0 ? kCar : kPole, centre, Vec3(0.3, 0.3, 0.3));
  }
  const LocalGraph graph = create(frame);
  std::vector<Vec3> means;
  for (const LocalObject& object : graph.objects) {
    means.push_back(object.belief.mean);
  }
  EXPECT_GT(means.size(), 20U);
  EXPECT_EQ(graph.edges, relativeNeighborhood(means));
}

}  // namespace
}  // namespace hgg::object_graph_test
