#include "map/map.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "map/test_map.h"

namespace hgg::map_test {
namespace {

constexpr ClassId kCar = 10, kRoad = 40;

Pose at(double x, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(x, 0, 0);
  return T;
}

/// A frame at a pose that becomes a keyframe where the map needs one.
void applyFrame(Map& map, Micros utime_us, const Pose& T) {
  MapUpdate update;
  update.keyframe = keyframeIfNeeded(map, {utime_us, T});
  map.apply(std::move(update));
}

std::vector<NodeId> nearByBruteForce(const Map& map, const Vec3& centre, double radius) {
  std::vector<NodeId> ids;
  for (const auto& [id, node] : map.nodes()) {
    if ((node.belief.mean - centre).norm() <= radius) {
      ids.push_back(id);
    }
  }
  return ids;
}

/// One random change of everything a map can be asked for.
MapUpdate randomUpdate(std::mt19937& random, const Map& map, double extent) {
  MapUpdate update;
  for (std::uint32_t n = below(random, 8); n > 0; --n) {
    update.created.push_back(randomNode(random, extent));
  }
  for (const auto& [id, node] : map.nodes()) {
    if (const std::uint32_t fate = below(random, 10); fate == 0) {
      update.removed.push_back(id);
    } else if (fate <= 2) {
      MapNode moved = randomNode(random, extent);
      moved.id = id;
      update.changed.push_back(moved);
    }
  }
  return update;
}

TEST(Map, NearEqualsBruteForceThroughInsertsChangesAndRemoves) {
  std::mt19937 random(1);
  Map map;
  for (int step = 0; step < 200; ++step) {
    map.apply(randomUpdate(random, map, 60));
    for (const double radius : {0.0, 3.0, 11.0, 25.0, 80.0, 500.0}) {
      const Vec3 centre = randomVector(random, 70);
      EXPECT_EQ(map.near(centre, radius), nearByBruteForce(map, centre, radius))
          << "step " << step << ", radius " << radius;
    }
  }
  EXPECT_GT(map.nodes().size(), 10U);
}

TEST(Map, NearFindsNodesOnTheRimOfTheRadiusAndOfItsCells) {
  std::vector<MapNode> lattice;
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      lattice.push_back(nodeAt(kCar, Vec3(10 * x, 10 * y, 0)));
    }
  }
  const Map map = mapOf(lattice);
  for (const double radius : {0.0, 10.0, 20.0}) {
    EXPECT_EQ(map.near(Vec3(0, 0, 0), radius), nearByBruteForce(map, Vec3(0, 0, 0), radius)) << radius;
  }
  EXPECT_EQ(map.near(Vec3(0, 0, 0), 10).size(), 5U);
}

TEST(Map, NearAnswersAtOnceForAnyRadiusAndPlace) {
  const Map map = mapOf({nodeAt(kCar, Vec3(1, 2, 3)), nodeAt(kCar, Vec3(1e8, 0, 0)), nodeAt(kCar, Vec3(1e300, 0, 0))});
  EXPECT_EQ(map.near(Vec3(0, 0, 0), 1e5), (std::vector<NodeId>{1}));
  EXPECT_EQ(map.near(Vec3(0, 0, 0), 1e9), (std::vector<NodeId>{1, 2}));
  EXPECT_EQ(map.near(Vec3(1e8, 0, 0), 1), (std::vector<NodeId>{2}));
  EXPECT_EQ(map.near(Vec3(1e300, 0, 0), 1), (std::vector<NodeId>{3}));
  EXPECT_TRUE(map.near(Vec3(-1e300, 2.2e10, 0), 100).empty());
  EXPECT_TRUE(Map{}.near(Vec3(0, 0, 0), 1e9).empty());
}

TEST(Map, FindTileFollowsEveryChange) {
  Map map = mapOf({tileNode(kRoad, {1, 2, 3}, Vec3(10, 20, 30)), tileNode(kCar, {1, 2, 3}, Vec3(11, 21, 31)),
                   nodeAt(kRoad, Vec3(0, 0, 0))});
  ASSERT_NE(map.findTile(kRoad, {1, 2, 3}), nullptr);
  EXPECT_EQ(map.findTile(kRoad, {1, 2, 3})->id, 1);
  EXPECT_EQ(map.findTile(kCar, {1, 2, 3})->id, 2);
  EXPECT_EQ(map.findTile(kRoad, {0, 0, 0}), nullptr);  // a thing lives in no tile

  MapUpdate update;
  MapNode changed = *map.find(1);
  changed.belief.mean = Vec3(12, 20, 30);
  update.changed.push_back(changed);
  update.removed.push_back(2);
  map.apply(std::move(update));
  EXPECT_EQ(map.findTile(kRoad, {1, 2, 3})->belief.mean.x(), 12);
  EXPECT_EQ(map.findTile(kCar, {1, 2, 3}), nullptr);
}

TEST(Map, IdsAreNeverReused) {
  std::mt19937 random(2);
  Map map;
  std::set<NodeId> given;
  for (int step = 0; step < 200; ++step) {
    std::set<NodeId> before;
    for (const auto& [id, node] : map.nodes()) {
      before.insert(id);
    }
    map.apply(randomUpdate(random, map, 60));
    for (const auto& [id, node] : map.nodes()) {
      EXPECT_EQ(node.id, id);
      if (!before.contains(id)) {
        EXPECT_TRUE(given.insert(id).second) << "id " << id << " came back";
      }
    }
  }
  EXPECT_EQ(map.nextId(), *given.rbegin() + 1);
}

TEST(Map, CreatedNodesGetIdsInTheirOrder) {
  const Map map = mapOf({nodeAt(kCar, Vec3(5, 0, 0)), nodeAt(kRoad, Vec3(1, 0, 0))});
  EXPECT_EQ(map.find(1)->label, kCar);
  EXPECT_EQ(map.find(2)->label, kRoad);
  EXPECT_EQ(map.find(3), nullptr);
}

TEST(Map, EveryApplyIsARevisionThatNamesWhatItTouched) {
  Map map = mapOf({nodeAt(kCar, Vec3(0, 0, 0)), nodeAt(kCar, Vec3(1, 0, 0)), nodeAt(kCar, Vec3(2, 0, 0))});
  EXPECT_EQ(map.revision(), 1);
  MapUpdate update;
  update.changed = {*map.find(3)};
  update.created = {nodeAt(kRoad, Vec3(3, 0, 0))};
  update.removed = {2, 1};
  const MapDelta delta = map.apply(std::move(update));
  EXPECT_EQ(delta.revision, 2);
  EXPECT_EQ(delta.changed, (std::vector<NodeId>{3, 4}));
  EXPECT_EQ(delta.removed, (std::vector<NodeId>{1, 2}));
  EXPECT_EQ(map.apply(MapUpdate{}).revision, 3);
}

TEST(Map, LeafCountFollowsEveryChange) {
  std::mt19937 random(3);
  Map map;
  for (int step = 0; step < 100; ++step) {
    map.apply(randomUpdate(random, map, 60));
    std::size_t leaves = 0;
    for (const auto& [id, node] : map.nodes()) {
      leaves += leavesOf(node).size();
    }
    EXPECT_EQ(map.leafCount(), leaves);
  }
}

TEST(Map, AddsAKeyframeExactlyWhenTheUpdateHasOne) {
  Map map;
  for (const bool has_keyframe : {false, true, true, false}) {  // one place: the map does not decide
    const std::size_t before = map.keyframes().poses().size();
    MapUpdate update;
    update.created = {nodeAt(kCar, Vec3(0, 0, 0))};
    if (has_keyframe) {
      update.keyframe = NewKeyframe{{5, at(1)}, {}};
    }
    const NodeId id = map.apply(std::move(update)).changed.at(0);
    EXPECT_EQ(map.keyframes().poses().size(), before + (has_keyframe ? 1 : 0));
    EXPECT_EQ(map.find(id)->anchor, map.keyframes().last());
  }
  EXPECT_EQ(map.keyframes().poses()[1].utime_us, 5);
  EXPECT_EQ(map.keyframes().poses()[1].T_map_body.matrix(), at(1).matrix());
}

TEST(Map, KeepsAKeyframeEveryTwoMetresOrTwentyDegrees) {
  Map map;
  Micros t = 0;
  for (int k = 0; k <= 80; ++k) {
    applyFrame(map, t++, at(0.125 * k));  // 10 m
  }
  EXPECT_EQ(map.keyframes().poses().size(), 6U);
  for (int k = 1; k <= 12; ++k) {
    applyFrame(map, t++, at(10, 7 * k));  // 84 degrees, a keyframe every third step
  }
  EXPECT_EQ(map.keyframes().poses().size(), 10U);
  for (int rest = 0; rest < 1000; ++rest) {
    applyFrame(map, t++, at(10, 84));
  }
  EXPECT_EQ(map.keyframes().poses().size(), 10U);
  EXPECT_EQ(map.keyframes().poses()[1].utime_us, 16);
}

TEST(Map, MemoryEstimateGrowsWithLeavesAndStaysWhenNothingIsNew) {
  std::mt19937 random(4);
  MapNode node = nodeAt(kCar, Vec3(0, 0, 0));
  const double empty = mapOf({node}).megabytes();
  for (int k = 0; k < 1000; ++k) {
    addLeaf(node, randomLeaf(random));
  }
  Map map = mapOf({node});
  EXPECT_NEAR(map.megabytes() - empty, 0.04, 1e-9);  // 40 B a leaf
  const double before = map.megabytes();
  for (int k = 0; k < 100; ++k) {
    MapUpdate update;
    update.changed = {*map.find(1)};
    map.apply(std::move(update));
  }
  EXPECT_EQ(map.megabytes(), before);
}

TEST(Map, RestoredAnswersLikeTheOriginal) {
  std::mt19937 random(5);
  Map map;
  for (int step = 0; step < 30; ++step) {
    map.apply(randomUpdate(random, map, 40));
  }
  std::vector<MapNode> nodes;
  for (const auto& [id, node] : map.nodes()) {
    nodes.push_back(node);
  }
  Map restored = Map::restore(nodes, map.keyframes(), {{10, "car"}}, map.revision(), map.nextId());
  EXPECT_EQ(restored.revision(), 30);
  EXPECT_EQ(restored.leafCount(), map.leafCount());
  EXPECT_EQ(restored.classNames().at(10), "car");
  EXPECT_EQ(restored.near(Vec3(0, 0, 0), 25), map.near(Vec3(0, 0, 0), 25));
  MapUpdate update;
  update.created = {nodeAt(kCar, Vec3(0, 0, 0))};
  EXPECT_EQ(restored.apply(update).changed, map.apply(update).changed);
}

TEST(Map, RestoredWithoutANextIdGoesOnAboveItsNodes) {
  MapNode node = nodeAt(kCar, Vec3(0, 0, 0));
  node.id = 41;
  Map map = Map::restore({node}, {}, {}, 7);
  MapUpdate update;
  update.created = {nodeAt(kCar, Vec3(1, 0, 0))};
  EXPECT_EQ(map.apply(update).changed, (std::vector<NodeId>{42}));
}

TEST(PackedLeaf, KeepsItsBeliefToFloatPrecision) {
  std::mt19937 random(6);
  for (int k = 0; k < 100; ++k) {
    const Belief b = randomBelief(random, 10);
    const Belief back = unpackLeaf(packLeaf(b));
    EXPECT_LE((back.mean - b.mean).norm(), 1e-6 * 20);
    EXPECT_LE((back.cov - b.cov).norm(), 1e-6 * b.cov.norm());
    EXPECT_EQ(back.cov, back.cov.transpose());
    EXPECT_EQ(back.kappa, b.kappa);
  }
  static_assert(sizeof(Leaf) == 40);
}

}  // namespace
}  // namespace hgg::map_test
