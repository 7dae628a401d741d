#include "place/zero_shot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "random_world.h"

namespace hgg::zero_shot_test {
namespace {

/// An open yard with few things, which make any two yards with them look alike.
World openYard(std::vector<Patch> things) {
  World world;
  world.things = std::move(things);
  addFloor(world, 12);
  for (const double y : {-9.0, 9.0}) {
    addWall(world, Vec3(-9, y, 0), Vec3(18, 0, 0));
  }
  return world;
}

void expectPose(const ZeroShot& z, const Pose& T_a_b, double metres, double degrees) {
  EXPECT_TRUE(z.accepted) << z.reason;
  const Vec6 xi = localCoordinates(z.T_a_b, T_a_b);
  EXPECT_LT(xi.head<3>().norm(), metres) << z.reason;
  EXPECT_LT(xi.tail<3>().norm() / kDegree, degrees) << z.reason;
}

TEST(ZeroShot, AMapLiesOnItself) {
  const Map map = mapOfWorld(randomWorld(1), Pose::Identity(), 1);
  const ZeroShot z = alignMaps(map, map);
  expectPose(z, Pose::Identity(), 1e-3, 0.01);
  ASSERT_EQ(z.pairs.size(), 30U);
  for (const auto& [a, b] : z.pairs) {
    EXPECT_EQ(a, b);
  }
}

TEST(ZeroShot, AnyYawAndSomeTilt) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const World world = randomWorld(seed);
    const Map a = mapOfWorld(world, Pose::Identity(), 10 + seed);
    for (const double yaw : {30.0, 90.0, 180.0, -135.0}) {
      const Pose T_a_b = frame(yaw, Vec3(4, -7, 0.5), seed);
      expectPose(alignMaps(a, mapOfWorld(world, T_a_b, 20 + seed)), T_a_b, 0.05, 0.3);
    }
  }
}

TEST(ZeroShot, PartialOverlap) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const World world = randomWorld(seed, 60);
    const Pose T_a_b = frame(77, Vec3(1, 2, 0), 2);
    const Map a = mapOfWorld(world, Pose::Identity(), 1, [](const Vec3& p) { return p.x() < 5; });
    const Map b = mapOfWorld(world, T_a_b, 2, [](const Vec3& p) { return p.x() > -5; });
    expectPose(alignMaps(a, b), T_a_b, 0.1, 0.5);
  }
}

TEST(ZeroShot, OtherWorldsAreRefused) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const ZeroShot z = alignMaps(mapOfWorld(randomWorld(seed), Pose::Identity(), 1),
                                 mapOfWorld(randomWorld(seed + 100), frame(40, Vec3(1, 1, 0)), 2));
    EXPECT_FALSE(z.accepted) << seed << ": " << z.reason;
    EXPECT_LT(z.score, z.threshold);
  }
}

TEST(ZeroShot, TwoThingsMakeNoPlace) {
  const auto at = [](ClassId label, double x, double y) {
    return Patch{label, Vec3(x, y, 0.5), 0.01 * Mat3::Identity()};
  };
  const World yard = openYard({at(kLamp, -3, 1), at(kTable, 4, 2)});
  const World other = openYard({at(kLamp, 2, 4), at(kTable, 2, -3.1)});
  const ZeroShot z = alignMaps(mapOfWorld(yard, Pose::Identity(), 1), mapOfWorld(other, frame(40, Vec3(1, 1, 0)), 2));
  EXPECT_FALSE(z.accepted);
  EXPECT_GT(z.score, z.threshold);
  EXPECT_NE(z.reason.find("too few things in common: 2 matched, 4 needed"), std::string::npos) << z.reason;
}

TEST(ZeroShot, TheSameWallsWithOtherFurnitureAreRefused) {
  World world = randomWorld(1), other = world;
  const World furniture = randomWorld(99);
  for (std::size_t k = 0; k < world.things.size(); ++k) {
    if (k % 3 != 0) {
      other.things[k] = furniture.things[k];
    }
  }
  EXPECT_FALSE(
      alignMaps(mapOfWorld(world, Pose::Identity(), 1), mapOfWorld(other, frame(40, Vec3(1, 1, 0)), 2)).accepted);
}

TEST(ZeroShot, NothingInCommonIsRefusedWithAReason) {
  const Map map = mapOfWorld(randomWorld(1), Pose::Identity(), 1);
  World single;
  single.things.push_back(randomWorld(1).things.front());
  World walls = randomWorld(1);
  walls.things.clear();
  for (const Map& other : {Map(), mapOfWorld(single, Pose::Identity(), 1), mapOfWorld(walls, Pose::Identity(), 1)}) {
    for (const ZeroShot& z : {alignMaps(map, other), alignMaps(other, map), alignMaps(other, other)}) {
      EXPECT_FALSE(z.accepted);
      EXPECT_FALSE(z.reason.empty());
      EXPECT_TRUE(z.T_a_b.matrix().allFinite());
    }
  }
}

TEST(ZeroShot, ThreeThingsWithoutLeavesAreTooFew) {
  Map map = mapOf({nodeAt(kChair, Vec3(0, 0, 0)), nodeAt(kChair, Vec3(5, 0, 0)), nodeAt(kTable, Vec3(0, 8, 0))});
  const ZeroShot z = alignMaps(map, map);
  EXPECT_FALSE(z.accepted);
  EXPECT_FALSE(z.reason.empty());
}

TEST(ZeroShot, LeavesOfNoExtentAreRefused) {
  Map map = mapOfWorld(randomWorld(1), Pose::Identity(), 1);
  std::vector<MapNode> nodes;
  for (const auto& [id, node] : map.nodes()) {
    nodes.push_back(node);
    Leaves flat = leavesOf(node);
    for (Leaf& leaf : flat) {
      leaf = packLeaf({unpackLeaf(leaf).mean, Mat3::Zero(), 50});
    }
    nodes.back().geometry = shareLeaves(std::move(flat));
  }
  const ZeroShot z = alignMaps(mapOf(nodes), mapOf(nodes));
  EXPECT_TRUE(z.T_a_b.matrix().allFinite());
}

TEST(ZeroShot, WhereNoTwoPairsAgreeThatIsTheReason) {
  const World yard = openYard({{kLamp, Vec3(0, 0, 0.5), 0.01 * Mat3::Identity()}});
  const Map map = mapOfWorld(yard, Pose::Identity(), 1);
  const ZeroShot z = alignMaps(map, map);
  EXPECT_FALSE(z.accepted);
  EXPECT_NE(z.reason.find("no two pairs of things agree"), std::string::npos) << z.reason;
}

TEST(ZeroShot, OneClassOfThingsIsEnough) {
  World world = randomWorld(5);
  for (Patch& thing : world.things) {
    thing.label = kChair;
    thing.cov = 0.04 * Mat3::Identity();
  }
  const Pose T_a_b = frame(-60, Vec3(3, 3, 0));
  expectPose(alignMaps(mapOfWorld(world, Pose::Identity(), 1), mapOfWorld(world, T_a_b, 2)), T_a_b, 0.05, 0.3);
}

TEST(ZeroShot, AMapOfManyLikeThingsLiesOnItself) {
  World world = randomWorld(5, 1200, 100);
  for (Patch& thing : world.things) {
    thing.label = kLamp;
    thing.cov = 0.01 * Mat3::Identity();
  }
  const Pose T_a_b = frame(-60, Vec3(3, 3, 0));
  const ZeroShot z = alignMaps(mapOfWorld(world, Pose::Identity(), 1), mapOfWorld(world, T_a_b, 2));
  expectPose(z, T_a_b, 0.05, 0.3);
  EXPECT_GT(z.pairs.size(), 1150U);
}

World lattice(int columns, int rows, double spacing) {
  World world;
  for (int x = 0; x < columns; ++x) {
    for (int y = 0; y < rows; ++y) {
      world.things.push_back({kLamp, Vec3(spacing * x, spacing * y, 1), 0.01 * Mat3::Identity()});
    }
  }
  addFloor(world, spacing * columns);
  return world;
}

TEST(ZeroShot, ALatticeOfPolesIsAmbiguous) {
  const World world = lattice(5, 5, 6);
  const ZeroShot z = alignMaps(mapOfWorld(world, Pose::Identity(), 1), mapOfWorld(world, frame(20, Vec3(1, 2, 0)), 2));
  EXPECT_FALSE(z.accepted);
  EXPECT_GT(z.score, z.threshold);  // refused for what it is
  EXPECT_NE(z.reason.find("ambiguous"), std::string::npos) << z.reason;
}

TEST(ZeroShot, ARowOfPolesThatGoesOnIsRefused) {
  const World world = lattice(20, 2, 8);
  const Map a = mapOfWorld(world, Pose::Identity(), 1, [](const Vec3& p) { return p.x() < 92; });
  const Map b = mapOfWorld(world, frame(10, Vec3(5, 0, 0)), 2, [](const Vec3& p) { return p.x() > 60; });
  const ZeroShot z = alignMaps(a, b);
  EXPECT_FALSE(z.accepted);
  EXPECT_NE(z.reason.find("ambiguous"), std::string::npos) << z.reason;
}

TEST(ZeroShot, ClassesAreMatchedByName) {
  const World world = randomWorld(6);
  World renumbered = world;
  const std::map<ClassId, ClassId> other{{kChair, kTable}, {kTable, 40}, {kLamp, kChair}, {kWall, 7}, {kFloor, 8}};
  std::map<ClassId, std::string> names;
  for (const auto& [id, name] : kNames) {
    names[other.at(id)] = name;
  }
  for (std::vector<Patch>* patches : {&renumbered.things, &renumbered.stuff}) {
    for (Patch& p : *patches) {
      p.label = other.at(p.label);
    }
  }
  const Pose T_a_b = frame(100, Vec3(2, 0, 0));
  const Map a = mapOfWorld(world, Pose::Identity(), 1);
  expectPose(alignMaps(a, mapOfWorld(renumbered, T_a_b, 2, {}, names)), T_a_b, 0.05, 0.3);
  EXPECT_FALSE(alignMaps(a, mapOfWorld(renumbered, T_a_b, 2, {}, {})).accepted);  // ids alone say otherwise
}

TEST(ZeroShot, TwoClassesOfOneNameAreOne) {
  std::map<ClassId, std::string> names = kNames;
  names[kTable] = "chair";
  const Map map = mapOfWorld(randomWorld(6), Pose::Identity(), 1, {}, names);
  const ZeroShot z = alignMaps(map, map);
  expectPose(z, Pose::Identity(), 1e-3, 0.01);
  EXPECT_EQ(z.pairs.size(), 30U);
}

TEST(ZeroShot, AnIdWithoutANameIsNotTakenForOneThatHasOne) {
  std::map<ClassId, std::string> names = kNames;
  names.erase(kChair);
  const Map a = mapOfWorld(randomWorld(6), Pose::Identity(), 1);
  const Map b = mapOfWorld(randomWorld(6), Pose::Identity(), 1, {}, names);
  for (const auto& [i, j] : alignMaps(a, b).pairs) {
    EXPECT_NE(a.nodes().at(i).label, kChair);
    EXPECT_NE(b.nodes().at(j).label, kChair);
  }
  EXPECT_EQ(alignMaps(b, b).pairs.size(), 30U);  // nobody says that it is another
}

TEST(ZeroShot, ASoftClassMatchesWhenToldSo) {
  const World world = randomWorld(7);
  World renamed = world;
  for (Patch& p : renamed.things) {
    p.label = p.label == kChair ? 20 : p.label == kTable ? 21 : p.label;
  }
  std::map<ClassId, std::string> names = kNames;
  names.erase(kChair), names.erase(kTable);
  names[20] = "armchair", names[21] = "desk";
  const Pose T_a_b = frame(-20, Vec3(2, 0, 0));
  const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(renamed, T_a_b, 2, {}, names);
  const ZeroShot hard = alignMaps(a, b);
  EXPECT_FALSE(hard.accepted) << hard.reason;
  const std::vector<SimilarClasses> similar{{"chair", "armchair", 0.8}, {"desk", "table", 0.8}};
  const ZeroShot soft = alignMaps(a, b, similar);
  expectPose(soft, T_a_b, 0.05, 0.3);
  EXPECT_EQ(soft.pairs.size(), 30U);
}

TEST(ZeroShot, TheOtherWayRoundIsTheInverse) {
  const World world = randomWorld(8);
  const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(world, frame(50, Vec3(3, 1, 0)), 2);
  const ZeroShot there = alignMaps(a, b), back = alignMaps(b, a);
  ASSERT_TRUE(there.accepted && back.accepted);
  EXPECT_LT(localCoordinates(there.T_a_b * back.T_a_b, Pose::Identity()).norm(), 0.02);
}

/// As many mistakes of labels as there are things: half of them second names of a thing, half of them nowhere near one.
World withGhosts(World world, unsigned seed) {
  const World made_up = randomWorld(seed);
  for (std::size_t k = 0; k < made_up.things.size(); ++k) {
    Patch ghost = k % 2 == 0 ? world.things[k] : made_up.things[k];
    ghost.label = static_cast<ClassId>(kChair + (ghost.label - kChair + 1) % 3);
    ghost.views = k % 2 == 0 ? 5 : 1;
    ghost.taken_for_wall = 30;
    world.things.push_back(ghost);
  }
  return world;
}

TEST(ZeroShot, GhostsDoNotCount) {
  const World world = randomWorld(10);
  const Pose T_a_b = frame(120, Vec3(3, 1, 0));
  const ZeroShot z =
      alignMaps(mapOfWorld(withGhosts(world, 50), Pose::Identity(), 1), mapOfWorld(withGhosts(world, 60), T_a_b, 2));
  expectPose(z, T_a_b, 0.05, 0.3);
  EXPECT_LT(z.evidence.things_missed, 5);
}

TEST(ZeroShot, TheSameMapsGiveTheSameAnswer) {
  const World world = randomWorld(9);
  const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(world, frame(50, Vec3(3, 1, 0)), 2);
  const ZeroShot first = alignMaps(a, b), second = alignMaps(a, b);
  EXPECT_EQ(first.T_a_b.matrix(), second.T_a_b.matrix());
  EXPECT_EQ(first.score, second.score);
  EXPECT_EQ(first.runner_up, second.runner_up);
  EXPECT_EQ(first.pairs, second.pairs);
}

PlacePrior priorAt(const Pose& T_a_b, double distance, double turn_deg) {
  return {T_a_b, Vec3::Zero(), distance, turn_deg * kDegree};
}

TEST(ZeroShotWithPrior, FindsWhatLiesWithin) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const World world = randomWorld(seed);
    const Pose T_a_b = frame(40, Vec3(4, -7, 0));
    const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(world, T_a_b, 2);
    expectPose(alignMaps(a, b, {}, priorAt(frame(45, Vec3(5, -6, 0)), 2, 10)), T_a_b, 0.05, 0.3);
  }
}

TEST(ZeroShotWithPrior, WhatLiesOutsideIsNotFound) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const World world = randomWorld(seed);
    const Pose T_a_b = frame(40, Vec3(4, -7, 0));
    const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(world, T_a_b, 2);
    ASSERT_TRUE(alignMaps(a, b).accepted);
    const PlacePrior too_far = priorAt(frame(40, Vec3(8, -7, 0)), 3.5, 10);
    const PlacePrior too_turned = priorAt(frame(60, Vec3(4, -7, 0)), 2, 10);
    for (const PlacePrior& prior : {too_far, too_turned}) {
      const ZeroShot z = alignMaps(a, b, {}, prior);
      EXPECT_FALSE(z.accepted);
      EXPECT_FALSE(z.reason.empty());
    }
  }
}

TEST(ZeroShotWithPrior, WhatLiesOutsideIsNoRival) {
  const World world = lattice(5, 5, 6);
  const Pose T_a_b = frame(20, Vec3(1, 2, 0));
  const Map a = mapOfWorld(world, Pose::Identity(), 1), b = mapOfWorld(world, T_a_b, 2);
  ASSERT_NE(alignMaps(a, b).reason.find("ambiguous"), std::string::npos);
  PlacePrior prior = priorAt(frame(22, Vec3(1.5, 1.5, 0)), 2, 10);
  const ZeroShot z = alignMaps(a, b, {}, prior);
  expectPose(z, T_a_b, 0.05, 0.3);
  EXPECT_LT(z.runner_up, 0.5 * z.score);
}

TEST(ZeroShotWithPrior, LooksAtItsOwnMiddleEvenWhereNoCliqueDoes) {
  const World yard = openYard({{kLamp, Vec3(0, 0, 0.5), 0.01 * Mat3::Identity()}});
  const Map map = mapOfWorld(yard, Pose::Identity(), 1);
  const ZeroShot z = alignMaps(map, map, {}, priorAt(Pose::Identity(), 2, 10));
  EXPECT_FALSE(z.accepted);  // one thing is too little
  EXPECT_GT(z.evidence.overlap, 0.5);
  EXPECT_LT(localCoordinates(z.T_a_b, Pose::Identity()).norm(), 0.05);
}

}  // namespace
}  // namespace hgg::zero_shot_test
