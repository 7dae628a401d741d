// The truth of where one can walk, against cases that can be worked out by hand.
#include "sim/walk_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/worlds/grounds.h"
#include "sim/worlds/outdoor.h"

namespace hgg::walk_truth_test {
namespace {

constexpr double kBody = 0.65;  // m, of the body above the ground

/// A floor of 12 x 8 m around the origin, its top at 0.
World floorWorld() {
  World world;
  addObject(world, objectOf(Indoor::kFloor), {block(0, 0, -0.1, 12.0, 8.0, 0.1)});
  return world;
}

/// A robot walks along x on the floor's southern side.
std::vector<Pose> southernWay() {
  std::vector<Pose> way;
  for (double x = -4.0; x <= 4.0; x += 0.5) {
    Pose pose = Pose::Identity();
    pose.translation() = Vec3(x, -2.5, kBody);
    way.push_back(pose);
  }
  return way;
}

Scene sceneOf(World world) {
  Scene scene;
  scene.world = std::move(world);
  return scene;
}

WalkTruth truthOf(const World& world) { return walkTruth(sceneOf(world), southernWay(), 1.0, {.limits = {}}); }

std::vector<WalkSurface> at(const WalkGrid& grid, double x, double y) {
  const auto column = grid.column(*grid.cellOf(x, y));
  return {column.begin(), column.end()};
}

/// The surface at a height.
WalkSurface at(const WalkGrid& grid, double x, double y, double z) {
  for (const WalkSurface& s : at(grid, x, y)) {
    if (std::abs(static_cast<double>(s.height) - z) < 0.02) {
      return s;
    }
  }
  ADD_FAILURE() << "no surface at " << x << " " << y << " " << z;
  return {};
}

Standing standing(const WalkGrid& grid, double x, double y, double z) { return at(grid, x, y, z).standing; }

TEST(WalkTruth, AnEmptyFloorIsFreeUpToTheVoidAroundIt) {
  const WalkGrid grid = truthOf(floorWorld()).grid;
  EXPECT_EQ(standing(grid, 0.05, 0.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 5.85, 0.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 5.95, 0.05, 0.0), Standing::kBlocked);  // beside the void
  EXPECT_TRUE(at(grid, 6.05, 0.05).empty());
  EXPECT_EQ(grid.known[*grid.cellOf(6.05, 0.05)], 1);
}

TEST(WalkTruth, AWallBlocksTheCellsItIsInAndNoOthers) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kWall), {block(2.0, 0, 0, 0.12, 2.0, 2.0)});  // x from 1.94 to 2.06
  const WalkGrid grid = truthOf(world).grid;
  EXPECT_EQ(standing(grid, 1.85, 0.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 1.95, 0.05, 0.0), Standing::kBlocked);
  EXPECT_EQ(standing(grid, 2.05, 0.05, 0.0), Standing::kBlocked);
  EXPECT_EQ(standing(grid, 2.15, 0.05, 0.0), Standing::kFree);
  EXPECT_TRUE(at(grid, 2.05, 0.05, 2.0).island);
}

TEST(WalkTruth, ALowKerbIsWalkedOverAndAHighOneIsBlockedAndSoIsItsEdge) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kFloor), {block(-3.0, 1, 0, 2.0, 2.0, 0.12)});
  addObject(world, objectOf(Indoor::kFloor), {block(3.0, 1, 0, 2.0, 2.0, 0.30)});
  const WalkGrid grid = truthOf(world).grid;
  for (const double x : {-4.15, -4.05}) {
    EXPECT_EQ(standing(grid, x, 1.05, 0.0), Standing::kFree);
  }
  for (const double x : {-3.95, -3.05}) {
    ASSERT_EQ(at(grid, x, 1.05).size(), 1U) << "the floor below the kerb is no place";
    EXPECT_EQ(standing(grid, x, 1.05, 0.12), Standing::kFree);
    EXPECT_FALSE(at(grid, x, 1.05, 0.12).island);
  }
  EXPECT_EQ(standing(grid, 1.85, 1.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 1.95, 1.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 2.05, 1.05, 0.0), Standing::kBlocked);
  EXPECT_EQ(standing(grid, 2.05, 1.05, 0.30), Standing::kBlocked);
  EXPECT_EQ(standing(grid, 2.15, 1.05, 0.30), Standing::kFree);
  EXPECT_TRUE(at(grid, 2.15, 1.05, 0.30).island);
  EXPECT_EQ(standing(grid, 2.15, 1.05, 0.0), Standing::kBlocked);
}

TEST(WalkTruth, ATableIsTwoLevels) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kTable), {block(-3.0, 1, 0.46, 1.0, 1.0, 0.04)});
  addObject(world, objectOf(Indoor::kTable), {block(0.0, 1, 0.70, 1.0, 1.0, 0.04)});
  addObject(world, objectOf(Indoor::kTable), {block(3.0, 1, 1.00, 1.0, 1.0, 0.04)});
  const WalkGrid grid = truthOf(world).grid;
  for (const double x : {-3.05, 0.05, 3.05}) {
    ASSERT_EQ(at(grid, x, 1.05).size(), 2U);
    EXPECT_FALSE(at(grid, x, 1.05)[0].island);
    EXPECT_TRUE(at(grid, x, 1.05)[1].island);
    EXPECT_EQ(at(grid, x, 1.05)[1].standing, Standing::kFree);
  }
  EXPECT_EQ(standing(grid, -3.05, 1.05, 0.0), Standing::kBlocked);
  EXPECT_EQ(standing(grid, 0.05, 1.05, 0.0), Standing::kClose);  // as high as the body: who can say
  EXPECT_EQ(standing(grid, 3.05, 1.05, 0.0), Standing::kFree);
}

TEST(WalkTruth, StairsConnectTwoLevelsAndTooHighOnesDoNot) {
  for (const double rise : {0.16, 0.30}) {
    World world = floorWorld();
    Shapes steps{block(2.5, 1, 0, 3.0, 2.0, 5 * rise)};
    for (int i = 0; i < 4; ++i) {
      steps.push_back(block(-0.05 + 0.3 * i, 1, 0, 0.3, 2.0, (i + 1) * rise));
    }
    addObject(world, objectOf(Indoor::kStairs), steps);
    const WalkGrid grid = truthOf(world).grid;
    const bool is_low = rise < 0.2;
    EXPECT_EQ(at(grid, 2.55, 1.05, 5 * rise).island, !is_low);
    EXPECT_EQ(at(grid, 2.55, 1.05).size(), is_low ? 1U : 2U);
    EXPECT_EQ(standing(grid, 0.05, 1.05, rise), is_low ? Standing::kFree : Standing::kBlocked);
    EXPECT_EQ(standing(grid, 2.55, 1.95, 5 * rise), Standing::kBlocked) << "the platform's edge";
  }
}

TEST(WalkTruth, AHolesRimIsBlockedAndItsBottomIsAnIsland) {
  World world;
  addBlocks(world, objectOf(Indoor::kFloor), {-6.0, -1.0, 1.0, 6.0}, {-4.0, 0.0, 2.0, 4.0},
            [](const Vec2& p) { return std::abs(p.x()) < 1.0 && p.y() > 0.0 && p.y() < 2.0 ? -0.8 : 0.0; });
  const WalkGrid grid = truthOf(world).grid;
  EXPECT_EQ(standing(grid, -1.15, 1.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, -1.05, 1.05, 0.0), Standing::kBlocked);
  EXPECT_EQ(standing(grid, -0.95, 1.05, -0.8), Standing::kFree);
  EXPECT_EQ(standing(grid, 0.05, 1.05, -0.8), Standing::kFree);
  EXPECT_TRUE(at(grid, 0.05, 1.05, -0.8).island);
}

TEST(WalkTruth, SlopesAreFreeUpToTheLimit) {
  for (const auto& [slope_deg, expected] : {std::pair{25.0, Standing::kFree},
                                            {30.0, Standing::kClose},
                                            {31.9, Standing::kClose},
                                            {40.0, Standing::kBlocked}}) {
    World world = floorWorld();
    const double rise = 2.0 * std::tan(slope_deg * M_PI / 180.0);
    addObject(world, objectOf(Indoor::kFloor), {rampBox({-1.0, 1, 0}, {1.0, 1, rise}, 2.0)});
    EXPECT_EQ(standing(truthOf(world).grid, 0.05, 1.05, rise * 0.525), expected) << slope_deg;
  }
}

TEST(WalkTruth, ABridgeIsFreeAboveAndBelow) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kFloor),
            {block(0, 1, 1.0, 2.0, 2.0, 0.1), rampBox({-4.0, 1, 0}, {-1.0, 1, 1.1}, 2.0)});
  const WalkGrid grid = truthOf(world).grid;
  ASSERT_EQ(at(grid, 0.05, 1.05).size(), 2U);
  for (const double z : {0.0, 1.1}) {
    EXPECT_EQ(standing(grid, 0.05, 1.05, z), Standing::kFree);
    EXPECT_FALSE(at(grid, 0.05, 1.05, z).island);
  }
  EXPECT_EQ(at(grid, -2.0, 1.05).size(), 2U) << "below the ramp is a place too low to stand in";
  EXPECT_EQ(at(grid, -2.0, 1.05)[0].standing, Standing::kBlocked);
}

TEST(WalkTruth, APoleOfFiveCentimetresIsFoundWhereverItStands) {
  const RandomKey key{7, 1};
  for (std::uint64_t i = 0; i < 40; ++i) {
    World world = floorWorld();
    const double x = uniform(key, 2 * i), y = uniform(key, 2 * i + 1);
    addObject(world, objectOf(Indoor::kPillar), {Cylinder{Vec3(x, y, 0), 0.025, 1.5}});
    const WalkGrid grid = truthOf(world).grid;
    int blocked = 0;
    for (double dx = -0.3; dx <= 0.3; dx += 0.1) {
      for (double dy = -0.3; dy <= 0.3; dy += 0.1) {
        const auto column = at(grid, x + dx, y + dy);
        blocked += !column.empty() && column.front().standing == Standing::kBlocked ? 1 : 0;
      }
    }
    EXPECT_GE(blocked, 1) << x << " " << y;
    EXPECT_LE(blocked, 4) << x << " " << y;
  }
}

TEST(WalkTruth, FoliageIsInTheWayAndCarriesNobody) {
  World world = floorWorld();
  addObject(world, objectOf(Outdoor::kVegetation), {Ellipsoid{Vec3(0, 1, 0.3), Vec3(0.5, 0.5, 0.4)}});
  const WalkGrid grid = truthOf(world).grid;
  ASSERT_EQ(at(grid, 0.05, 1.05).size(), 1U);
  EXPECT_EQ(at(grid, 0.05, 1.05)[0].standing, Standing::kBlocked);
}

TEST(WalkTruth, WhatBlocksIsNamed) {
  World world;
  addBlocks(world, objectOf(Indoor::kFloor), {-6.0, 3.0, 6.0}, {-4.0, 4.0},
            [](const Vec2& p) { return p.x() > 3.0 ? -0.8 : 0.0; });
  addObject(world, objectOf(Indoor::kTable), {block(-3.0, 1, 0.46, 1.0, 1.0, 0.04)});
  addObject(world, objectOf(Indoor::kPillar), {Cylinder{Vec3(-1.02, 1.02, 0), 0.025, 2.0}});
  addObject(world, objectOf(Indoor::kFloor), {rampBox({0.0, 1, 0}, {1.0, 1, 1.0}, 1.0)});
  const WalkGrid grid = truthOf(world).grid;
  const auto cause = [&](double x, double z) { return at(grid, x, 1.05, z).cause; };
  EXPECT_EQ(cause(-3.05, 0.0), static_cast<ClassId>(Indoor::kTable));
  EXPECT_EQ(cause(-3.05, 0.5), 0);
  EXPECT_EQ(cause(-1.05, 0.0), static_cast<ClassId>(Indoor::kPillar));
  EXPECT_EQ(cause(0.55, 0.55), kCauseSlope);
  EXPECT_EQ(cause(2.95, 0.0), kCauseEdge);
  EXPECT_EQ(cause(2.05, 0.0), 0);
}

TEST(WalkTruth, WhatMovesIsNotThere) {
  Scene scene = sceneOf(floorWorld());
  for (const double x : {-2.0, 2.0}) {
    addObject(scene.world, objectOf(Indoor::kBox), {block(x, 1, 0, 1.0, 1.0, 1.0)});
  }
  scene.world.objects[1].dynamic = true;
  scene.motions.push_back({1, [](double /*time*/) { return std::optional(Pose::Identity()); }});
  Pose away = Pose::Identity();
  away.translation() = Vec3(-1.5, 0, 0);  // and this one was pushed aside
  scene.motions.push_back({2, [away](double time) { return std::optional(time < 5.0 ? Pose::Identity() : away); }});
  const WalkGrid grid = walkTruth(scene, southernWay(), 10.0, {.limits = {}}).grid;
  EXPECT_EQ(standing(grid, -2.05, 1.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 2.05, 1.05, 0.0), Standing::kFree);
  EXPECT_EQ(standing(grid, 0.55, 1.05, 0.0), Standing::kBlocked);
}

TEST(WalkTruth, IsTheSameWhateverTheThreads) {
  const Scene scene = makeWalk(3);
  std::vector<Pose> way;
  for (double time = 0; time < 20.0; time += 1.0) {
    way.push_back(scene.T_world_body(time));
  }
  const WalkGrid one = walkTruth(scene, way, 0.0, {.limits = {}, .threads = 1}).grid;
  const WalkGrid four = walkTruth(scene, way, 0.0, {.limits = {}, .threads = 4}).grid;
  ASSERT_EQ(one.surfaces.size(), four.surfaces.size());
  for (std::size_t i = 0; i < one.surfaces.size(); ++i) {
    EXPECT_EQ(one.surfaces[i].height, four.surfaces[i].height);
    EXPECT_EQ(one.surfaces[i].standing, four.surfaces[i].standing);
    EXPECT_EQ(one.surfaces[i].island, four.surfaces[i].island);
  }
}

TEST(WalkTruth, ReturnsCountWhereTheySaySomethingOfTheWay) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kTable), {block(-3.0, 1, 0.46, 1.0, 1.0, 0.04)});
  addObject(world, objectOf(Indoor::kFloor),
            {block(1.5, 1, 1.0, 2.0, 2.0, 0.1), rampBox({-2.0, 1, 0}, {0.5, 1, 1.1}, 2.0)});
  addObject(world, objectOf(Indoor::kPillar), {Cylinder{Vec3(4.02, 1.02, 0), 0.025, 2.0}});
  WalkTruth truth = truthOf(world);
  const auto hit = [&](double x, double y, double z) { countReturn(truth, Vec3(x, y, z), 0); };
  hit(0.05, -3.05, 0.01), hit(0.05, -3.05, 0.5);  // the floor, and something in the air above it
  hit(-3.05, 1.05, 0.5);                          // the table's top: it says that the floor below is blocked
  hit(1.55, 1.05, 1.1);                           // the deck: it says nothing of the floor below
  hit(4.02, 1.02, 0.5), hit(4.02, 1.02, 1.5);     // a pole beside the body, and above it
  EXPECT_EQ(at(truth.grid, 0.05, -3.05, 0.0).returns, 1U);
  EXPECT_EQ(at(truth.grid, -3.05, 1.05, 0.0).returns, 1U);
  EXPECT_EQ(at(truth.grid, -3.05, 1.05, 0.5).returns, 1U);
  EXPECT_EQ(at(truth.grid, 1.55, 1.05, 0.0).returns, 0U);
  EXPECT_EQ(at(truth.grid, 1.55, 1.05, 1.1).returns, 1U);
  EXPECT_EQ(at(truth.grid, 4.02, 1.02, 0.0).returns, 1U);
  truth.stays_there[0] = false;
  hit(0.05, -3.05, 0.01);
  EXPECT_EQ(at(truth.grid, 0.05, -3.05, 0.0).returns, 1U) << "what moves says nothing";
}

TEST(WalkTruth, ACeilingSeenFromBelowIsNoIsland) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kCeiling), {block(0, 0, 2.8, 12.0, 8.0, 0.1)});
  WalkTruth truth = truthOf(world);
  countReturn(truth, Vec3(0.05, 0.05, 2.8), 1);
  countReturn(truth, Vec3(0.05, 0.05, 0.0), 0);
  const WalkGrid grid = finishedGrid(truth);
  ASSERT_EQ(at(grid, 0.05, 0.05).size(), 1U);
  EXPECT_EQ(at(grid, 0.05, 0.05)[0].returns, 1U);
}

TEST(WalkTruth, IslandsNoBeamMetAreLeftOut) {
  World world = floorWorld();
  addObject(world, objectOf(Indoor::kBox), {block(-2.0, 1, 0, 1.0, 1.0, 1.0)});
  WalkTruth truth = truthOf(world);
  countReturn(truth, Vec3(-2.05, 1.05, 1.0), 1);
  const WalkGrid grid = finishedGrid(truth);
  EXPECT_EQ(at(grid, -2.05, 1.05).size(), 2U);
  EXPECT_EQ(at(grid, -2.25, 1.05).size(), 1U);
}

TEST(WalkTruth, TheWalkWorldHoldsWhatItIsNamedFor) {
  const Scene scene = makeWalk(1);
  std::vector<Pose> way;
  for (double time = 0; time < scene.duration / 2.0; time += 0.5) {
    way.push_back(scene.T_world_body(time));
  }
  const WalkGrid grid = walkTruth(scene, way, 0.0, {.limits = {}}).grid;
  std::size_t kerb = 0, high_kerb = 0, below = 0, high_enough = 0;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    for (const WalkSurface& s : grid.column(cell)) {
      const double z = static_cast<double>(s.height);
      kerb += std::abs(z - 0.12) < 1e-3 && !s.island && s.standing == Standing::kFree ? 1 : 0;
      high_kerb += std::abs(z - 0.30) < 1e-3 && s.island ? 1 : 0;
    }
    const auto column = grid.column(cell);
    const bool has_plate = column.size() > 1 && column[1].island;
    below += has_plate && std::abs(static_cast<double>(column[1].height) - 0.8) < 1e-3 &&
                     column[0].standing == Standing::kBlocked
                 ? 1
                 : 0;
    high_enough += has_plate && std::abs(static_cast<double>(column[1].height) - 1.3) < 1e-3 &&
                           column[0].standing == Standing::kFree
                       ? 1
                       : 0;
  }
  EXPECT_NEAR(static_cast<double>(kerb), 256.0, 33.0);
  EXPECT_NEAR(static_cast<double>(high_kerb), 256.0, 33.0);
  EXPECT_NEAR(static_cast<double>(below), 100.0, 21.0);
  EXPECT_NEAR(static_cast<double>(high_enough), 100.0, 21.0);
}

}  // namespace
}  // namespace hgg::walk_truth_test
