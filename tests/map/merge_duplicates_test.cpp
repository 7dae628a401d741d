#include <gtest/gtest.h>

#include <algorithm>

#include "map/file.h"
#include "map/fuse.h"
#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::merge_duplicates_test {
namespace {

/// A box of evenly spread surface, its leaves a lattice over it.
MapNode boxNode(ClassId label, const Vec3& centre, const Vec3& half, double kappa = 600) {
  MapNode node = nodeAt(label, centre, 1, kappa);
  node.belief.cov = (half.cwiseAbs2() / 3).asDiagonal();
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      const Mat3 cov = (half.cwiseAbs2() / 12).asDiagonal();
      addLeaf(node, packLeaf({half.cwiseProduct(Vec3(x, y, 0)), cov, kappa / 4}));
    }
  }
  return node;
}

MapNode carNode(const Vec3& centre, double kappa = 600) { return boxNode(kCar, centre, Vec3(2.1, 0.9, 0.7), kappa); }

MapNode roadNode(const Vec3& centre, double tile_size) {
  MapNode node = boxNode(kRoad, centre, Vec3(4, 4, 0.05), 900);
  node.classes = {};
  node.stuff = true;
  node.tile = tileOf(centre, tile_size);
  return node;
}

/// Cars and poles on a lattice of 7 m, on nine tiles of road, each displaced by up to `jitter` m.
std::vector<MapNode> yard(std::mt19937& random, double jitter) {
  const double tile_size = Config{}.creation.tile_size;
  std::vector<MapNode> nodes;
  const auto near = [&](const Vec3& p) { return Vec3(p + jitter * randomVector(random, 1).normalized()); };
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) {
      const Vec3 p(7 * x, 7 * y, 0.7);
      nodes.push_back((x + y) % 2 == 0 ? carNode(near(p)) : boxNode(kPole, near(p), Vec3(0.1, 0.1, 1.5), 200));
    }
  }
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      nodes.push_back(roadNode(near(tile_size * Vec3(x, y, 0)), tile_size));
    }
  }
  return nodes;
}

double leafKappaOf(const MapNode& node) {
  double sum = 0;
  for (const Leaf& leaf : leavesOf(node)) {
    sum += leaf.kappa;
  }
  return sum;
}

std::vector<NodeId> idsFrom(NodeId first, NodeId last) {
  std::vector<NodeId> ids;
  for (NodeId id = first; id <= last; ++id) {
    ids.push_back(id);
  }
  return ids;
}

MapUpdate merged(const Map& map, const std::vector<NodeId>& reactivated) {
  return mergeDuplicates(map, reactivated, testClasses(), Config{});
}

void expectNothing(const MapUpdate& update) {
  EXPECT_TRUE(update.changed.empty());
  EXPECT_TRUE(update.created.empty());
  EXPECT_TRUE(update.removed.empty());
  EXPECT_TRUE(update.evidence.empty());
  EXPECT_FALSE(update.keyframe);
}

TEST(MergeDuplicates, TwoCopiesOfAPlaceEndAsOneWithTheEvidenceOfBoth) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::vector<MapNode> nodes = yard(random, 0);
    const auto count = static_cast<NodeId>(nodes.size());
    const std::vector<MapNode> copy = yard(random, 0.1);
    nodes.insert(nodes.end(), copy.begin(), copy.end());
    for (const auto& reactivated : {idsFrom(1, count), idsFrom(count + 1, 2 * count), idsFrom(1, 2 * count)}) {
      Map map = mapOf(nodes);
      const Map before = map;
      const MapDelta delta = map.apply(merged(map, reactivated));
      ASSERT_EQ(map.nodes().size(), static_cast<std::size_t>(count));
      EXPECT_EQ(delta.changed, idsFrom(1, count));
      EXPECT_EQ(delta.removed, idsFrom(count + 1, 2 * count));
      EXPECT_EQ(map.keyframes().poses().size(), 1U);
      for (const auto& [id, node] : map.nodes()) {
        const MapNode &a = *before.find(id), &b = *before.find(id + count);
        EXPECT_EQ(node.label, a.label);
        EXPECT_EQ(node.tile, a.tile);
        EXPECT_EQ(node.belief.kappa, a.belief.kappa + b.belief.kappa);
        EXPECT_NEAR(leafKappaOf(node), leafKappaOf(a) + leafKappaOf(b), 1e-2);
        EXPECT_LE((node.belief.mean - 0.5 * (a.belief.mean + b.belief.mean)).norm(), 1e-9);
        EXPECT_EQ(node.anchor, a.anchor);
      }
    }
  }
}

TEST(MergeDuplicates, WhatNeitherWokeNorLiesOnWhatDidStaysAsItWas) {
  std::mt19937 random(6);
  std::vector<MapNode> nodes = yard(random, 0);
  const auto count = static_cast<NodeId>(nodes.size());
  const std::vector<MapNode> copy = yard(random, 0.1);
  nodes.insert(nodes.end(), copy.begin(), copy.end());
  const Map before = mapOf(nodes);
  const MapUpdate update = merged(before, {2, count});
  ASSERT_EQ(update.changed.size(), 2U);
  EXPECT_EQ(update.changed[0].id, 2);
  EXPECT_EQ(update.changed[1].id, count);
  EXPECT_EQ(update.removed.size(), 2U);
  Map map = before;
  map.apply(update);
  EXPECT_NE(map.find(3 + count), nullptr);
  EXPECT_EQ(map.find(3)->belief.kappa, before.find(3)->belief.kappa);
}

TEST(MergeDuplicates, ThreeOfOnePlaceEndAsOneWhoeverWokeAndNoIdIsBothChangedAndRemoved) {
  const Vec3 p(5, 5, 0.7), q(10, 0, 0);
  const Vec3 off(0.05, 0, 0);
  const Map before = mapOf(
      {carNode(p), carNode(p + off), carNode(p - off), roadNode(q, 10), roadNode(q + off, 10), roadNode(q - off, 10)});
  for (const auto& reactivated : {idsFrom(1, 6), std::vector<NodeId>{1, 4}, {2, 5}, {3, 6}, {2, 3, 5, 6}}) {
    Map map = before;
    const MapDelta delta = map.apply(merged(map, reactivated));
    EXPECT_EQ(delta.changed, (std::vector<NodeId>{1, 4}));
    EXPECT_EQ(delta.removed, (std::vector<NodeId>{2, 3, 5, 6}));
    EXPECT_EQ(map.find(1)->belief.kappa, 1800);
    EXPECT_EQ(map.find(4)->belief.kappa, 2700);
  }
}

TEST(MergeDuplicates, ObjectsBesideEachOtherStayTwo) {
  const double gap = 0.6;
  const Map map = mapOf({carNode(Vec3(0, 0, 0.7)), carNode(Vec3(0, 1.8 + gap, 0.7)), carNode(Vec3(4.2 + gap, 0, 0.7)),
                         boxNode(kPole, Vec3(0, -2, 1), Vec3(0.1, 0.1, 1)),
                         boxNode(kPole, Vec3(0, -2.2 - gap, 1), Vec3(0.1, 0.1, 1))});
  expectNothing(merged(map, idsFrom(1, 5)));
}

TEST(MergeDuplicates, OtherClassesAndOtherTilesStayApart) {
  MapNode pole = carNode(Vec3(0, 0, 0.7));
  pole.label = kPole;
  pole.classes = {};
  addViews(pole.classes, {{kPole, 1000.0F}});
  const Map map = mapOf({carNode(Vec3(0, 0, 0.7)), pole, roadNode(Vec3(0, 0, 0), 10), roadNode(Vec3(10, 0, 0), 10)});
  expectNothing(merged(map, idsFrom(1, 4)));
}

TEST(MergeDuplicates, ViewsOfTwoTimesAddUpThoseOfPiecesOfOneTimeDoNot) {
  std::mt19937 random(3);
  for (const bool is_later : {false, true}) {
    MapNode keep, other;
    keep.belief = other.belief = randomBelief(random, 1);
    keep.views = 10, other.views = 12;
    keep.first_us = 100, keep.last_us = 200;
    other.first_us = is_later ? 300 : 150, other.last_us = 400;
    absorb(keep, other, 0.1, merge);
    EXPECT_EQ(keep.views, is_later ? 22 : 12);
  }
}

TEST(MergeDuplicates, OfTwoTilesThatAMoveHasMadeOneOneNodeIsLeft) {
  constexpr double kTile = 10;
  std::vector<MapNode> nodes;
  KeyframeGraph graph;
  for (int k = 0; k < 3; ++k) {
    Pose T = Pose::Identity();
    T.translation().x() = kTile * k;
    graph.add({k, T});
    MapNode node;
    node.id = k + 1;
    node.label = 40;
    node.stuff = true;
    node.anchor = k;
    node.belief = {Vec3(kTile * k, 0, 0), Mat3::Identity(), 50};
    node.tile = tileOf(node.belief.mean, kTile);
    nodes.push_back(node);
  }
  Map map = Map::restore(nodes, graph, {}, 1);
  map.setTileSize(kTile);
  Pose T = Pose::Identity();
  T.translation().x() = 7;
  const MapDelta delta = map.apply(MapCorrection{{{0, T}}, {}});
  EXPECT_TRUE(delta.reactivated.empty());
  EXPECT_EQ(delta.colliding, (std::vector<NodeId>{1}));
  const MapDelta after = map.apply(merged(map, delta.colliding));
  EXPECT_EQ(after.changed, (std::vector<NodeId>{1}));
  EXPECT_EQ(after.removed, (std::vector<NodeId>{2}));
  EXPECT_EQ(map.find(1)->belief.kappa, 100);
}

TEST(MergeDuplicates, OfNothingAndOfIdsThatAreGoneIsNothing) {
  std::mt19937 random(7);
  const Map map = mapOf(yard(random, 0));
  expectNothing(merged(map, {}));
  expectNothing(merged(map, {777, 778}));
  expectNothing(merged(Map{}, {}));
  expectNothing(merged(Map{}, {1}));
  Map same = map;
  same.apply(merged(map, {}));
  EXPECT_EQ(same.keyframes().poses().size(), 1U);
}

TEST(MergeDuplicates, WhatSleepsIsNotMergedWith) {
  std::mt19937 random(8);
  Map map;
  map.setDriftReach(0.1);
  MapUpdate first;
  first.keyframe = NewKeyframe{};
  first.created = {carNode(Vec3(0, 0, 0.7)), roadNode(Vec3(0, 0, 0), 10)};
  map.apply(first);
  MapUpdate second;
  Pose T = Pose::Identity();
  T.translation() = Vec3(3, 0, 0);
  second.keyframe = NewKeyframe{{0, T}, {{0, -1, T, 1, 0.1, false}}};
  second.created = first.created;
  map.apply(second);
  ASSERT_FALSE(map.isActive(*map.find(1)));
  expectNothing(merged(map, {3, 4}));
  map.apply(MapCorrection{{}, {{0, 1, T, 0.01, 0.001, true}}});
  const MapUpdate update = merged(map, {1, 2});
  EXPECT_EQ(update.removed.size(), 2U);
}

TEST(MergeDuplicates, ACopyWithoutEvidenceLeavesItsViewsBehind) {
  MapNode empty = carNode(Vec3(0, 0, 0.7), 0);
  empty.views = 9;
  Map map = mapOf({carNode(Vec3(0, 0, 0.7)), empty});
  map.apply(merged(map, {2}));
  ASSERT_EQ(map.nodes().size(), 1U);
  EXPECT_EQ(map.find(1)->views, 9);
}

}  // namespace
}  // namespace hgg::merge_duplicates_test
