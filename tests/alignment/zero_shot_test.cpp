#include "alignment/zero_shot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "map/test_map.h"

namespace hgg {
namespace {

constexpr ClassId kChair = 10, kTable = 11, kLamp = 12, kWall = 1, kFloor = 2;
constexpr double kDegree = M_PI / 180;
const std::map<ClassId, std::string> kNames{
    {kChair, "chair"}, {kTable, "table"}, {kLamp, "lamp"}, {kWall, "wall"}, {kFloor, "floor"}};

/// What there is: things and pieces of flat surfaces.
struct Patch {
  ClassId label;
  Vec3 mean;
  Mat3 cov;
  int views = 10;
  float taken_for_wall = 0;  // views
};
struct World {
  std::vector<Patch> things, stuff;
};

Mat3 plate(const Vec3& normal, double half) {
  const Vec3 n = normal.normalized();
  return 0.33 * half * half * (Mat3::Identity() - n * n.transpose()) + 1e-4 * n * n.transpose();
}

void addWall(World& world, const Vec3& from, const Vec3& along) {
  const Vec3 normal = along.cross(Vec3::UnitZ());
  for (double s = 0.5; s < along.norm(); ++s) {
    for (const double z : {0.5, 1.5}) {
      world.stuff.push_back({kWall, from + s * along.normalized() + z * Vec3::UnitZ(), plate(normal, 0.5)});
    }
  }
}

void addFloor(World& world, double extent) {
  for (double x = -extent + 0.5; x < extent; ++x) {
    for (double y = -extent + 0.5; y < extent; ++y) {
      world.stuff.push_back({kFloor, Vec3(x, y, 0), plate(Vec3::UnitZ(), 0.5)});
    }
  }
}

World randomWorld(unsigned seed, int things = 30, double extent = 15) {
  std::mt19937 random(seed);
  World world;
  for (int k = 0; k < things; ++k) {
    const Vec3 p = randomVector(random, extent);
    const double size = 0.1 * (1 + k % 3);
    world.things.push_back(
        {static_cast<ClassId>(kChair + k % 3), Vec3(p.x(), p.y(), 0.4 + size), size * size * Mat3::Identity()});
  }
  for (int k = 0; k < 8; ++k) {
    const Vec3 p = randomVector(random, 0.7 * extent), way = randomVector(random, 1);
    addWall(world, Vec3(p.x(), p.y(), 0), 6 * Vec3(way.x(), way.y(), 0).normalized());
  }
  addFloor(world, extent);
  return world;
}

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

/// The map of a world by someone whose frame has the pose T_world_map, of what `sees` admits; things jitter by 2 cm.
Map mapOfWorld(const World& world, const Pose& T_world_map, unsigned noise_seed,
               const std::function<bool(const Vec3&)>& sees = {}, std::map<ClassId, std::string> names = kNames) {
  std::mt19937 random(noise_seed);
  std::vector<MapNode> nodes;
  std::map<std::tuple<ClassId, int, int>, std::size_t> tiles;  // of this map's own frame
  for (const std::vector<Patch>* patches : {&world.things, &world.stuff}) {
    for (const Patch& patch : *patches) {
      if (sees && !sees(patch.mean)) {
        continue;
      }
      const Belief belief = transform(T_world_map.inverse(), {patch.mean + randomVector(random, 0.02), patch.cov, 50});
      const bool stuff = patches == &world.stuff;
      const std::tuple tile(patch.label, static_cast<int>(std::floor(belief.mean.x() / 3)),
                            static_cast<int>(std::floor(belief.mean.y() / 3)));
      if (!stuff || !tiles.contains(tile)) {
        tiles[tile] = nodes.size();
        MapNode node;
        node.label = patch.label;
        node.stuff = stuff;
        node.tile = {std::get<1>(tile), std::get<2>(tile), 0};
        node.views = patch.views;
        if (!stuff) {
          addViews(node.classes, {{kWall, patch.taken_for_wall}});
          addViews(node.classes, {{patch.label, static_cast<float>(patch.views)}});
        }
        node.belief = belief;
        nodes.push_back(node);
      }
      nodes[stuff ? tiles[tile] : nodes.size() - 1].leaves.push_back(packLeaf(belief));  // T_map_object is identity
    }
  }
  Map map = mapOf(std::move(nodes));
  map.setClassNames(std::move(names));
  return map;
}

Pose frame(double yaw_deg, const Vec3& t, double tilt_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = (Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()) *
                Eigen::AngleAxisd(tilt_deg * kDegree, Vec3(1, 2, 0).normalized()))
                   .toRotationMatrix();
  T.translation() = t;
  return T;
}

void expectPose(const ZeroShot& z, const Pose& T_a_b, double metres, double degrees) {
  EXPECT_TRUE(z.accepted) << z.reason;
  const Vec6 xi = poseDifference(z.T_a_b, T_a_b);
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

TEST(ZeroShot, ThingsWithoutLeavesAreRefused) {
  Map map = mapOf({nodeAt(kChair, Vec3(0, 0, 0)), nodeAt(kChair, Vec3(5, 0, 0)), nodeAt(kTable, Vec3(0, 8, 0))});
  const ZeroShot z = alignMaps(map, map);
  EXPECT_FALSE(z.accepted);
  EXPECT_NE(z.reason.find("no surveyed surface in common"), std::string::npos) << z.reason;
}

TEST(ZeroShot, LeavesOfNoExtentAreRefused) {
  Map map = mapOfWorld(randomWorld(1), Pose::Identity(), 1);
  std::vector<MapNode> nodes;
  for (const auto& [id, node] : map.nodes()) {
    nodes.push_back(node);
    for (Leaf& leaf : nodes.back().leaves) {
      leaf = packLeaf({unpackLeaf(leaf).mean, Mat3::Zero(), 50});
    }
  }
  const ZeroShot z = alignMaps(mapOf(nodes), mapOf(nodes));
  EXPECT_TRUE(z.T_a_b.matrix().allFinite());
}

TEST(ZeroShot, ASurfaceIndexBearsAnyRadiusAndAnyPoint) {
  const double infinite = std::numeric_limits<double>::infinity();
  std::vector<Surface> surfaces(3);
  surfaces[1].mean = Vec3::Constant(1e300);
  surfaces[2].mean = Vec3::Constant(std::nan(""));
  for (const double radius : {0.0, -1.0, std::nan(""), 1e-300, 0.5}) {
    const SurfaceIndex index(surfaces, radius);
    for (const double x : {0.0, -1e300, infinite, std::nan("")}) {
      std::vector<std::size_t> found{7};
      index.near(Vec3::Constant(x), found);
      EXPECT_EQ(found.size(), radius == 0.5 && x == 0 ? 1U : 0U) << radius << ", " << x;
    }
  }
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
  EXPECT_LT(poseDifference(there.T_a_b * back.T_a_b, Pose::Identity()).norm(), 0.02);
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

}  // namespace
}  // namespace hgg
