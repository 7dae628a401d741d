#include <gtest/gtest.h>

#include <algorithm>

#include "core/se3.h"
#include "core/units.h"
#include "landmarks.h"
#include "map/test_map.h"
#include "place/zero_shot.h"

namespace hgg::things_only_test {
namespace {

/// A thing of a graph from elsewhere: a box without leaves.
struct Box {
  ClassId label;
  Vec3 centre, size;
};

/// A room of 8 x 6 m with boxes of six classes.
std::vector<Box> randomRoom(unsigned seed, int n = 24) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Box> room;
  for (int k = 0; k < n; ++k) {
    const Vec3 size(0.3 + 0.7 * unit(random), 0.3 + 0.7 * unit(random), 0.4 + unit(random));
    room.push_back({static_cast<ClassId>(1 + k % 6), {8 * unit(random), 6 * unit(random), 2 * unit(random)}, size});
  }
  return room;
}

/// Node ids are 1, 2, ... in the order of the boxes. Seen from a frame that is moved by T, middles off by `jitter` (m).
Map mapOfBoxes(const std::vector<Box>& boxes, const Pose& T = Pose::Identity(), double jitter = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<MapNode> nodes;
  for (const Box& box : boxes) {
    const Vec3 off(normal(random), normal(random), normal(random));
    MapNode node = nodeAt(box.label, T * Vec3(box.centre + jitter * off));
    node.belief.cov = T.linear() * (box.size.cwiseAbs2() / 12).asDiagonal() * T.linear().transpose();
    nodes.push_back(std::move(node));
  }
  return mapOf(std::move(nodes));
}

const Pose kT_b_a = uprightPose(2.1, Vec3(5, -7, 0.4));

/// Cut at x = 3 m and x = 5 m: the two metres between are in both halves.
std::pair<std::vector<Box>, std::vector<Box>> halvesOf(const std::vector<Box>& room) {
  std::pair<std::vector<Box>, std::vector<Box>> halves;
  for (const Box& box : room) {
    if (box.centre.x() < 5) {
      halves.first.push_back(box);
    }
    if (box.centre.x() > 2) {
      halves.second.push_back(box);
    }
  }
  return halves;
}

TEST(ThingsOnly, AGraphLiesOnItsMovedSelf) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const std::vector<Box> room = randomRoom(seed);
    const ZeroShot z = alignMaps(mapOfBoxes(room), mapOfBoxes(room, kT_b_a, 0.05, seed));
    ASSERT_TRUE(z.accepted) << z.reason;
    const Vec6 off = localCoordinates(z.T_a_b * kT_b_a, Pose::Identity());
    EXPECT_LT((z.T_a_b * kT_b_a * Vec3(4, 3, 1) - Vec3(4, 3, 1)).norm(), 0.1);
    EXPECT_LT(off.tail<3>().norm(), 3 * kDegree);
    EXPECT_GE(z.pairs.size(), room.size() - 2);
    EXPECT_TRUE(std::ranges::all_of(z.pairs, [](const auto& p) { return p.first == p.second; }));
  }
}

TEST(ThingsOnly, HalvesThatOverlapAreLaidOverEachOther) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto [first, second] = halvesOf(randomRoom(seed, 40));
    const ZeroShot z = alignMaps(mapOfBoxes(first), mapOfBoxes(second, kT_b_a, 0.05, seed));
    EXPECT_TRUE(z.accepted) << seed << ": " << z.reason;
    EXPECT_LT((z.T_a_b * kT_b_a * Vec3(4, 3, 1) - Vec3(4, 3, 1)).norm(), 0.15);
  }
}

TEST(ThingsOnly, OtherRoomsAreRefused) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const ZeroShot z = alignMaps(mapOfBoxes(randomRoom(seed)), mapOfBoxes(randomRoom(seed + 100), kT_b_a));
    EXPECT_FALSE(z.accepted) << seed << ": " << z.reason;
    EXPECT_LT(z.score, z.threshold);
  }
}

TEST(ThingsOnly, AThingUnderAnotherNameIsPairedButIsNoEvidence) {
  std::vector<Box> room = randomRoom(3), renamed = room;
  for (std::size_t k = 0; k < renamed.size(); k += 4) {
    renamed[k].label = 9;  // which the other map does not have
  }
  const ZeroShot z = alignMaps(mapOfBoxes(room), mapOfBoxes(renamed, kT_b_a, 0.03));
  ASSERT_TRUE(z.accepted) << z.reason;
  EXPECT_EQ(z.evidence.things_matched, 18);
  EXPECT_GE(z.pairs.size(), 22U);
  EXPECT_TRUE(std::ranges::all_of(z.pairs, [](const auto& p) { return p.first == p.second; }));
  EXPECT_TRUE(std::ranges::is_sorted(z.pairs));
}

TEST(ThingsOnly, WhatOneMapHasWhereTheOtherHasNothingSpeaksAgainst) {
  const std::vector<Box> room = randomRoom(4);
  std::vector<Box> emptied = room;
  std::erase_if(
      emptied, [](const Box& b) { return b.label > 2 && (b.centre.head<2>() - Vec3(4, 3, 0).head<2>()).norm() < 2.5; });
  ASSERT_LT(emptied.size(), room.size());
  const ZeroShot whole = alignMaps(mapOfBoxes(room), mapOfBoxes(room, kT_b_a));
  const ZeroShot part = alignMaps(mapOfBoxes(room), mapOfBoxes(emptied, kT_b_a));
  EXPECT_EQ(whole.evidence.things_missed, 0);
  EXPECT_GT(part.evidence.things_missed, 1);
}

TEST(ThingsOnly, AreNotLaidOverEachOtherWithinAPrior) {  // as loops are closed: a drive's map has leaves
  const Map map = mapOfBoxes(randomRoom(1));
  EXPECT_FALSE(alignMaps(map, map, {}, PlacePrior{Pose::Identity(), Vec3::Zero(), 1, 1}).accepted);
}

}  // namespace
}  // namespace hgg::things_only_test
