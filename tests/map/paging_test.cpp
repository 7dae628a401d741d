#include "map/paging.h"

#include <gtest/gtest.h>

#include <tuple>

#include "map/drive_along.h"
#include "map/file.h"
#include "map/shelf.h"

namespace hgg::paging_test {
namespace {

TEST(Paging, WhatComesBackIsWhatWentAway) {
  Map map = driveAlong(40);
  const std::string before = encodeMap(map);
  Shelf shelf;
  const PageStore store = shelf.store(30);
  pageOutBeyond(map, store, Vec3(0, 0, 0), {});
  EXPECT_LT(map.nodes().size(), 16U);
  EXPECT_GT(shelf.pages.size(), 30U);
  EXPECT_NE(encodeMap(map), before);
  const MapDelta delta = bringBack(map, store, Vec3::Zero(), 1e6);
  EXPECT_TRUE(shelf.pages.empty());
  EXPECT_GT(delta.changed.size(), 60U);
  EXPECT_TRUE(delta.reactivated.empty());
  EXPECT_EQ(encodeMap(map), before);
}

TEST(Paging, EdgesLeaveWithAPageAndComeBackWithIt) {
  Map map = driveAlong(40);
  map.setEdgeModel({0.01, 0.5});
  const std::vector<Edge> before = map.graph().edges();
  Shelf shelf;
  const PageStore store = shelf.store(30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  EXPECT_EQ(map.graph().size(), map.nodes().size());
  EXPECT_LT(map.graph().edges().size(), before.size());
  bringBack(map, store, Vec3::Zero(), 1e6);
  const std::vector<Edge> after = map.graph().edges();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(std::tie(after[k].a, after[k].b, after[k].weight), std::tie(before[k].a, before[k].b, before[k].weight));
  }
}

TEST(Paging, LeavesAreNotCopiedOnTheWay) {
  Map map = driveAlong(40);
  const GeometryBlock far = map.geometry(71);
  Shelf shelf;
  const PageStore store = shelf.store(30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  ASSERT_EQ(map.find(71), nullptr);
  bringBack(map, store, Vec3(175, 0, 0), 10);
  EXPECT_EQ(map.geometry(71), far);
}

TEST(Paging, BringsBackEveryNodeThatMayLieWithinTheRadiusAndNoOther) {
  Map map = driveAlong(40);
  const Map whole = map;
  Shelf shelf;
  const PageStore store = shelf.store(0);
  pageOutBeyond(map, store, Vec3(0, 100, 0), {});
  EXPECT_EQ(map.nodes().size(), 2U);  // the last keyframe's
  bringBack(map, store, Vec3(100, 0, 0), 12);
  EXPECT_EQ(map.near(Vec3(100, 0, 0), 12), whole.near(Vec3(100, 0, 0), 12));
  EXPECT_LT(shelf.taken, 10);
  bringBack(map, store, Vec3(100, 0, 0), 12);
  EXPECT_LT(shelf.taken, 10);  // nothing comes twice
}

TEST(Paging, APageFollowsWhatALoopDidToItsKeyframeMeanwhile) {
  Map map = driveAlong(40), stayed = map;
  Shelf shelf;
  const PageStore store = shelf.store(30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  MapCorrection correction;
  for (KeyframeId k = 20; k < 40; ++k) {
    correction.moved.emplace_back(k, at(5 * k + 11, 0.1 * k));
  }
  map.apply(correction);
  stayed.apply(correction);
  const MapDelta delta = bringBack(map, store, Vec3::Zero(), 1e6);
  EXPECT_GE(delta.changed.size(), 38U);   // two nodes of 19 moved keyframes at least; the last one's had stayed
  EXPECT_FALSE(delta.colliding.empty());  // road nodes now lie in tiles of others
  ASSERT_EQ(map.nodes().size(), stayed.nodes().size());
  for (const auto& [id, node] : stayed.nodes()) {
    EXPECT_LT((map.find(id)->belief.mean - node.belief.mean).norm(), 1e-9) << id;
    EXPECT_EQ(map.find(id)->tile, node.tile) << id;
  }
}

TEST(Paging, NeitherPendingMergesNorTheLastKeyframeLeave) {
  Map map = driveAlong(40);
  Shelf shelf;
  pageOutBeyond(map, shelf.store(0), Vec3(0, 1000, 0), {21});
  EXPECT_NE(map.find(21), nullptr);
  EXPECT_NE(map.find(22), nullptr);  // of the same page
  EXPECT_NE(map.find(79), nullptr);
  EXPECT_EQ(map.nodes().size(), 4U);
}

TEST(Paging, AnInfiniteRadiusKeepsEverything) {
  Map map = driveAlong(10);
  pageOutBeyond(map, PageStore{}, Vec3::Zero(), {});
  EXPECT_EQ(map.nodes().size(), 20U);
}

TEST(Paging, WhatHasComeWithinReachWhileItWasAwayIsReactivated) {
  Map map = driveAlong(40);
  map.setDriftReach(0.1);  // 25 constraints of 2 cm
  map.startAt(0);
  ASSERT_FALSE(map.isActive(KeyframeId{38}));
  Shelf shelf;
  const PageStore store = shelf.store(30);
  pageOutBeyond(map, store, Vec3::Zero(), {});
  MapCorrection loop;
  loop.loops.push_back({0, 38, at(190), 0.02, 1e-3, true});
  map.apply(loop);
  map.startAt(0);
  ASSERT_TRUE(map.isActive(KeyframeId{38}));
  const MapDelta delta = bringBack(map, store, Vec3(190, 0, 0), 1);
  EXPECT_TRUE(std::ranges::binary_search(delta.reactivated, 77));
}

}  // namespace
}  // namespace hgg::paging_test
