#include "map/same_thing.h"

#include <gtest/gtest.h>

#include "map/second_nodes.h"
#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::same_thing_test {
namespace {

constexpr double kRadius = 0.3;  // m, of clustering
/// `share`: of the evidence, below which what touches is a fragment.
SameThing ruleOf(double radius, double share, double gate) {
  SameThing rule;
  rule.cluster_radius = radius, rule.sigma_floor = 0.02, rule.merge_overlap = 0.5, rule.fragment_share = share;
  rule.gate = gate;
  return rule;
}
const SameThing kRule = ruleOf(kRadius, 0.1, 3);

/// A box with leaves of this edge over all of its sides but the lower one, a few points each.
MapNode boxNode(ClassId label, const Vec3& centre, const Vec3& half, double edge, double views = 100) {
  MapNode node = nodeAt(label, centre, 1, 0);
  node.classes = {};
  addViews(node.classes, {{label, static_cast<float>(views)}});
  node.belief = {Vec3::Zero(), Mat3::Zero(), 0};
  const Mat3 cov = (edge * edge / 12) * Mat3::Identity();
  const auto count = [&](int k) { return std::max(1, static_cast<int>(std::ceil(2 * half[k] / edge))); };
  for (int x = 0; x < count(0); ++x) {
    for (int y = 0; y < count(1); ++y) {
      for (int z = 0; z < count(2); ++z) {
        const bool is_inside = x > 0 && x + 1 < count(0) && y > 0 && y + 1 < count(1) && z + 1 < count(2);
        if (!is_inside) {
          const Vec3 share((x + 0.5) / count(0), (y + 0.5) / count(1), (z + 0.5) / count(2));
          const Belief leaf{half.cwiseProduct(2 * share - Vec3::Ones()), cov, 20};
          node.belief = node.belief.kappa > 0 ? merge(node.belief, leaf) : leaf;
          addLeaf(node, packLeaf(leaf));
        }
      }
    }
  }
  node.belief.mean += centre;
  return node;
}

MapNode carAt(const Vec3& centre, double edge = 0.3) { return boxNode(kCar, centre, {2.1, 0.9, 0.7}, edge); }

/// An object of a frame at the origin with the leaves of a node.
LocalObject objectLike(const MapNode& node) {
  LocalObject object;
  object.label = node.label;
  object.belief = node.belief;
  object.T_body_object = node.T_map_object;
  for (const Leaf& leaf : leavesOf(node)) {
    object.leaves.push_back(unpackLeaf(leaf));
  }
  return object;
}

TEST(AreOneObject, CarsParkedHalfAMetreApartStayTwo) {
  for (const double edge : {0.3, 0.6, 0.9}) {  // sharp leaves, and those of few beams
    EXPECT_FALSE(areOneObject(carAt({0, 0, 0.7}, edge), carAt({0, 2.3, 0.7}, edge), kRule)) << edge;  // side by side
    EXPECT_FALSE(areOneObject(carAt({0, 0, 0.7}, edge), carAt({4.7, 0, 0.7}, edge), kRule)) << edge;  // in a row
  }
}

TEST(AreOneObject, APieceThatLiesOnTheOtherIsOneWithIt) {
  const MapNode bed = boxNode(kCar, {0, 0, 0.3}, {1, 0.45, 0.2}, 0.2);
  EXPECT_TRUE(areOneObject(bed, boxNode(kCar, {-1.03, 0, 0.45}, {0.03, 0.45, 0.45}, 0.1), ruleOf(0.12, 0.01, 1)));
}

TEST(AreOneObject, WithoutPiecesTheyStayThingsOfTheirOwn) {
  SameThing rule = ruleOf(0.12, 0.01, 1);
  const MapNode bed = boxNode(kCar, {0, 0, 0.3}, {1, 0.45, 0.2}, 0.2);
  const MapNode head = boxNode(kCar, {-1.03, 0, 0.45}, {0.03, 0.45, 0.45}, 0.1);
  EXPECT_TRUE(areOneObject(bed, head, rule));
  rule.loose_pieces = true;
  EXPECT_FALSE(areOneObject(bed, head, rule));
}

TEST(IsOtherName, AnotherNameForMostOfAThingsSurfaceIsThatThing) {
  const MapNode car = carAt({0, 0, 0.7});
  MapNode side = boxNode(kPole, {0.3, -0.85, 0.7}, {1, 0.05, 0.5}, 0.3, 15);
  EXPECT_FALSE(isOtherName(car, side, 0.02));  // nobody called it a car there
  addViews(side.classes, {{kCar, 6.0F}});
  EXPECT_TRUE(isOtherName(car, side, 0.02));
  EXPECT_FALSE(isOtherName(side, car, 0.02));  // the car was called so more often
}

TEST(IsOtherName, WhatHangsOnAThingIsOneOfItsOwn) {
  const auto called = [](MapNode node, ClassId also) {
    addViews(node.classes, {{also, 10.0F}});
    return node;
  };
  const MapNode pole = boxNode(kPole, {0, 0, 1}, {0.04, 0.04, 1}, 0.3);
  const MapNode plate = called(boxNode(kCar, {0, 0, 2.15}, {0.02, 0.18, 0.18}, 0.1, 15), kPole);
  EXPECT_FALSE(isOtherName(pole, plate, 0.02));
  const MapNode desk = boxNode(kCar, {0, 0, 0.7}, {0.8, 0.4, 0.02}, 0.1);
  const MapNode screen = called(boxNode(kPole, {0, 0, 0.95}, {0.05, 0.3, 0.2}, 0.1, 15), kCar);
  EXPECT_FALSE(isOtherName(desk, screen, 0.02));
}

TEST(KeepViews, WhatIsPairedWithItsNeighbourIsNoViewOfIt) {
  const MapNode pole = boxNode(kPole, {10, 0, 1}, {0.05, 0.05, 1}, 0.2);
  const Map map = mapOf({pole});
  LocalGraph local;
  for (const double off : {0.05, 0.3, 1.7}) {
    local.objects.push_back(objectLike(boxNode(kPole, {10, off, 1}, {0.05, 0.05, 1}, 0.2)));
  }
  local.objects.push_back(objectLike(boxNode(kPole, {10, 0, 2.1}, {0.05, 0.05, 0.1}, 0.2)));  // only its top
  std::vector<ObjectPair> pairs{{0, 1, 0}, {1, 1, 0}, {2, 1, 0}, {3, 1, 0}};
  keepViews(pairs, map, local, Pose::Identity(), testClasses(), Config{});
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(pairs[0].local, 0);
  EXPECT_EQ(pairs[1].local, 1);
  EXPECT_EQ(pairs[2].local, 3);
}

/// A car, seen again from a keyframe which may have drifted from that of the first view by `sigma` (m, per axis) so
/// that frames were not matched with the first view.
Map carSeenTwice(double sigma) {
  Map map;
  map.setDriftReach(0.01);
  MapUpdate first;
  first.keyframe = NewKeyframe{};
  first.created = {carAt({5, 0, 0.7})};
  map.apply(std::move(first));
  MapUpdate second;
  second.keyframe = NewKeyframe{{1'000'000, Pose(Eigen::Translation3d(3, 0, 0))},
                                {{0, 1, Pose(Eigen::Translation3d(3, 0, 0)), sigma, 1e-4}}};
  second.created = {carAt({5.1, 0, 0.7}), carAt({5, 20, 0.7})};
  map.apply(std::move(second));
  return map;
}

TEST(MergeSecondNodes, WhatWasSeenAgainAfterLittleDriftIsOne) {
  Map map = carSeenTwice(0.05);
  ASSERT_FALSE(map.isActive(*map.find(1)));
  const double kappa = map.find(1)->belief.kappa + map.find(2)->belief.kappa;
  const MapDelta delta = map.apply(mergeSecondNodes(map, testClasses(), Config{}));
  EXPECT_EQ(delta.changed, (std::vector<NodeId>{1}));
  EXPECT_EQ(delta.removed, (std::vector<NodeId>{2}));
  EXPECT_EQ(map.find(1)->belief.kappa, kappa);
  EXPECT_NE(map.find(3), nullptr);
  EXPECT_TRUE(mergeSecondNodes(map, testClasses(), Config{}).changed.empty());
}

TEST(MergeSecondNodes, WhatMayHaveDriftedByMoreThanClusteringBridgesWaitsForALoop) {
  const Map map = carSeenTwice(3);
  EXPECT_TRUE(mergeSecondNodes(map, testClasses(), Config{}).removed.empty());
}

}  // namespace
}  // namespace hgg::same_thing_test
