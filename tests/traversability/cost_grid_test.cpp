#include "traversability/cost_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.h"
#include "surfaces_world.h"

namespace hgg::cost_grid_test {
namespace {

TEST(CostGrid, LevelGroundThatWasSeenIsFreeAndTheRestUnknown) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  const CostGrid grid = world.grid();
  for (const double v : {-1.55, -0.35, 0.05, 1.55}) {
    ASSERT_TRUE(isFree(grid, v, 0.15)) << v;
    EXPECT_NEAR(supportAt(grid, v, 0.15)->height, 0, 0.02);
    EXPECT_LT(supportAt(grid, v, 0.15)->slope, 0.1);
    EXPECT_GT(supportAt(grid, v, 0.15)->confidence, 0.9);
  }
  EXPECT_EQ(costAt(grid, 3, 0), kCostUnknown);
  EXPECT_EQ(costAt(grid, -3.95, -3.95), kCostUnknown);
}

TEST(CostGrid, AKerbIsAStepForSomeRobotsAndTooHighForOthers) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 0, 2);
  world.add({0, -2, 0}, {0, 4, 0}, {0, 0, 0.14});
  world.addFloor(0, -2, 2, 2, 0.14);
  TraversabilityConfig low;
  low.step_height = 0.1;
  const CostGrid climber = world.grid(), roller = world.grid({-4, -4, 4, 4}, low);
  for (const double x : {-0.15, -0.05}) {
    EXPECT_TRUE(isFree(climber, x, 0.55, 0)) << x;
  }
  EXPECT_TRUE(isFree(climber, 0.05, 0.55, 0.14));
  EXPECT_NEAR(supportAt(climber, -0.05, 0.55)->step, 0.14, 0.03);
  EXPECT_EQ(costAt(roller, -0.05, 0.55), kCostBlocked);
  EXPECT_TRUE(isFree(roller, -0.55, 0.55));
  EXPECT_TRUE(isFree(roller, 0.55, 0.55, 0.14));
}

TEST(CostGrid, ATableTopIsNotTheFloorAndItsEdgeIsInTheWay) {
  SurfacesWorld world;
  world.setEye({0, 0, 1.2});
  world.addFloor(-2, -2, 2, 2);
  world.addFloor(0.5, -0.5, 1.5, 0.5, 0.6);  // lower than the body
  const CostGrid grid = world.grid();
  const auto column = grid.column(grid.shape.cell(grid.shape.columnOf(1), grid.shape.rowOf(0)));
  ASSERT_EQ(column.size(), 2U);
  EXPECT_NEAR(column[0].height, 0, 0.02);
  EXPECT_NEAR(column[1].height, 0.6, 0.02);
  EXPECT_NEAR(column[0].clearance, 0.6, 0.05);
  EXPECT_EQ(column[0].cost, kCostBlocked);
  EXPECT_TRUE(isFree(grid, 0.15, 0));
}

TEST(CostGrid, UnderAHighTableIsRoom) {
  SurfacesWorld world;
  world.setEye({0, 0, 1.2});
  world.addFloor(-2, -2, 2, 2);
  world.addFloor(0.5, -0.5, 1.5, 0.5, 1.0);
  EXPECT_TRUE(isFree(world.grid(), 1, 0));
}

TEST(CostGrid, ChairLegsAreInTheWayAndTheFloorBetweenThemIsUnderTheSeat) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  for (const double x : {0.5, 0.95}) {
    for (const double y : {-0.2, 0.2}) {
      world.addSides(x, y, x + 0.03, y + 0.03, 0, 0.45);
    }
  }
  world.addFloor(0.5, -0.2, 0.98, 0.23, 0.45);
  const CostGrid grid = world.grid();
  for (const double x : {0.51, 0.96}) {
    EXPECT_EQ(costAt(grid, x, 0.21), kCostBlocked);
    EXPECT_EQ(costAt(grid, x, -0.19), kCostBlocked);
  }
  EXPECT_EQ(costAt(grid, 0.75, 0), kCostBlocked);
  EXPECT_TRUE(isFree(grid, 0.15, 0));
}

TEST(CostGrid, WhatHangsAtTheHeightOfTheBodyIsInTheWay) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  world.add({0.5, -2, 0.5}, {0, 4, 0}, {0, 0, 0.1});  // a bar
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, 0.55, 0.35), kCostBlocked);
  EXPECT_TRUE(isFree(grid, 0.35, 0.35));
  EXPECT_TRUE(isFree(grid, 0.15, 0.35));
}

TEST(CostGrid, APoleOfFiveCentimetresIsSeen) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  world.addSides(0.52, 0.52, 0.57, 0.57, 0, 2);
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, 0.55, 0.55), kCostBlocked);
  EXPECT_TRUE(isFree(grid, 0.15, 0.55));
}

TEST(CostGrid, AFaceBelowTheGroundOnBothSidesIsTheFarSideOfATrench) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2, 0, 30, 1.0);  // leaves of a distant look span it
  world.add({0, -2, 0}, {0, 4, 0}, {0, 0, -0.15}, 10);
  const CostGrid grid = world.grid();
  for (const double x : {-0.15, -0.05, 0.05, 0.15}) {
    EXPECT_EQ(costAt(grid, x, 0.55), kCostBlocked) << x;
  }
  EXPECT_TRUE(isFree(grid, -0.55, 0.55));
  EXPECT_TRUE(isFree(grid, 0.55, 0.55));
}

TEST(CostGrid, WhereFinerLeavesLieLowerCoarseOnesSpanATrench) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2, 0, 30, 1.0);
  world.addFloor(0, -2, 0.1, 2, -0.11, 10);  // a ring of beams on its far side
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, 0.05, 0.55), kCostBlocked);
  EXPECT_TRUE(isFree(grid, 0.55, 0.55));
}

TEST(CostGrid, ASinglePointBelowTheGroundIsNoTrench) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2, 0, 30, 1.0);
  world.addFloor(0.04, 0.54, 0.06, 0.56, -0.11, 1, 0.02);
  EXPECT_TRUE(isFree(world.grid(), 0.05, 0.55));
}

TEST(CostGrid, TheEdgeOfADropIsNoGround) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 0, 2);
  world.addFloor(0, -2, 2, 2, -1);
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, -0.05, 0.55), kCostBlocked);
  EXPECT_TRUE(isFree(grid, -0.45, 0.55));
}

TEST(CostGrid, WhereTheBottomOfADropIsSeenOnlyFartherOutItsEdgeIsNoGroundEither) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 0, 2);
  world.addFloor(0.6, -2, 2, 2, -1);  // the edge hides what is right below it
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, -0.05, 0.55), kCostBlocked);
  EXPECT_EQ(costAt(grid, 0.25, 0.55), kCostUnknown) << "nothing is filled in over a drop";
}

TEST(CostGrid, ABridgeAndTheRoadUnderItAreTwoLevels) {
  SurfacesWorld world;
  world.setEye({0, 0, 4});
  world.addEye({-1.5, 1.9, 0.6});
  world.addFloor(-2, -2, 2, 2);
  world.addFloor(-2, -0.8, 2, 0.8, 3);
  const CostGrid grid = world.grid();
  EXPECT_TRUE(isFree(grid, 0.05, 0.05, 0));
  EXPECT_TRUE(isFree(grid, 0.05, 0.05, 3));
  EXPECT_EQ(costAt(grid, 0.05, 0.75, 3), kCostBlocked) << "its edge";
  EXPECT_TRUE(isFree(grid, 0.05, 1.55, 0));
}

TEST(CostGrid, ACeilingCarriesNobody) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  world.addFloor(-2, -2, 2, 2, 2.5);
  const CostGrid grid = world.grid();
  EXPECT_TRUE(isFree(grid, 0.05, 0.05, 0));
  EXPECT_FALSE(isFree(grid, 0.05, 0.05, 2.5));
}

TEST(CostGrid, SteepGroundIsNoGroundAndARampIs) {
  for (const double degrees : {20.0, 40.0}) {
    SurfacesWorld world;
    const double rise = std::tan(degrees * kDegree);
    world.setEye({-2, 0, 3});
    world.add({-2, -2, 0}, {3, 0, 3 * rise}, {0, 4, 0});
    const CostGrid grid = world.grid();
    EXPECT_EQ(isFree(grid, -0.55, 0.05, 1.45 * rise), degrees < 30) << degrees;
    EXPECT_NEAR(supportAt(grid, -0.55, 0.05, 1.45 * rise)->slope, degrees * kDegree, 0.06);
  }
}

TEST(CostGrid, GapsBetweenLeavesThatAgreeAreFilledWithoutConfidence) {
  SurfacesWorld world;
  for (int k = 0; k < 12; ++k) {  // rings 0.4 m wide, 0.2 m apart, of leaves as long as that
    world.add({-3 + 0.6 * k, -2, 0}, {0.4, 0, 0}, {0, 4, 0}, 30, 0.4);
  }
  const CostGrid grid = world.grid();
  const Support* s = supportAt(grid, -2.45, 0.05);
  ASSERT_NE(s, nullptr);
  EXPECT_FALSE(s->seen);
  EXPECT_EQ(s->confidence, 0);
  EXPECT_TRUE(isWalkable(s->cost));
  EXPECT_GT(s->cost, supportAt(grid, -2.15, 0.05)->cost);
}

TEST(CostGrid, AWideGapStaysUnknown) {
  SurfacesWorld world;
  world.addFloor(-2, -2, -0.5, 2);
  world.addFloor(0.5, -2, 2, 2);
  EXPECT_EQ(costAt(world.grid(), 0, 0.05), kCostUnknown);
}

TEST(CostGrid, AFewScatteredPointsInOneLeafAreNoWall) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  world.add({-1, -1, 0}, {2, 2, 0}, {0, 0, 1.5}, 0.001, 3);  // one leaf across the floor, a few points
  EXPECT_TRUE(isFree(world.grid(), 0.05, 0.05));
}

TEST(CostGrid, BelowAPlateOfWhichOnlyTheRimWasSeenItIsUnknown) {
  // The plate hangs as high as the sensor: nobody saw its upper or its lower side.
  const auto below = [](const Vec3& p_eye) {
    SurfacesWorld world;
    world.setEye(p_eye);
    world.addFloor(-3, -2, 3, 2);
    world.addSides(0.5, -0.5, 1.5, 0.5, 0.45, 0.75);
    return costAt(world.grid(), 1.05, 0.05);
  };
  EXPECT_EQ(below({-1, 0, 0.6}), kCostUnknown);
  // A hoop: from above one looks into it.
  EXPECT_TRUE(isWalkable(below({-1, 0, 2.2})));
}

TEST(CostGrid, GroundInsideACarOfWhichOnlyTheSidesWereSeenIsUnknownHoweverWellItWasSeenBelowThem) {
  SurfacesWorld world;
  world.setEye({-2.5, 0, 1.2});
  world.addEye({2.5, 2.5, 1.2});
  world.addFloor(-3, -3, 3, 3);
  world.addSides(-0.9, -1.5, 0.9, 1.5, 0.25, 1.2);
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, 0.05, 0.05), kCostUnknown);
  EXPECT_EQ(costAt(grid, -0.55, 1.25), kCostUnknown);
  EXPECT_TRUE(isFree(grid, 1.55, 0.05)) << "beside it";
  world.addEye({0, 0, 0.6});  // somebody was in there: it is a room
  EXPECT_TRUE(isFree(world.grid(), 0.35, 0.35));
}

TEST(CostGrid, AMapWithoutKeyframesHidesNothing) {
  SurfacesWorld world;
  world.addFloor(-3, -3, 3, 3);
  world.addSides(-0.9, -1.5, 0.9, 1.5, 0.25, 1.2);
  Map bare;
  MapUpdate update;
  const Map seen = world.map();
  for (const auto& [id, node] : seen.nodes()) {
    update.created.push_back(node);
    update.created.back().anchor = -1;
  }
  bare.apply(std::move(update));
  EXPECT_TRUE(isFree(buildCostGrid(bare, *gridShape({-4, -4, 4, 4}, 0.1), {}), 0.05, 0.05));
}

TEST(CostGrid, GroundThatEndsInViewWithNothingBehindItIsAnEdge) {
  SurfacesWorld world;
  world.setEye({-2.5, 0, 0.6});
  world.addFloor(-3, -2, 0, 2);
  const CostGrid grid = world.grid();
  EXPECT_EQ(costAt(grid, -0.05, 0.55), kCostBlocked);
  EXPECT_EQ(costAt(grid, -0.15, 0.55), kCostBlocked) << "a leaf reaches over the edge";
  EXPECT_TRUE(isFree(grid, -0.55, 0.55));
}

TEST(CostGrid, GroundThatEndsInTheShadowOfAWallOrWhereItWasHardlySeenIsNoEdge) {
  SurfacesWorld shadow;
  shadow.setEye({-2.5, 0, 0.6});
  shadow.addFloor(-3, -2, 0, 2);
  shadow.add({0.05, -2, 0}, {0, 4, 0}, {0, 0, 1});
  EXPECT_TRUE(isFree(shadow.grid(), -0.25, 0.55));
  SurfacesWorld thin;
  thin.setEye({-2.5, 0, 0.6});
  thin.addFloor(-3, -2, 0, 2, 0, 0.5, 0.4);
  EXPECT_TRUE(isFree(thin.grid(), -0.55, 0.55));
}

TEST(CostGrid, WhatLiesBelowTheSensorIsNoHoleForIt) {
  SurfacesWorld world;  // a blind circle of 1 m around the place it started from
  world.setEye({0, 0, 0.6});
  world.addFloor(-3, -3, -1, 3);
  world.addFloor(1, -3, 3, 3);
  world.addFloor(-1, 1, 1, 3);
  world.addFloor(-1, -3, 1, -1);
  EXPECT_TRUE(isFree(world.grid(), -1.35, 0.05));
}

TEST(CostGrid, ACoarseLeafOverATrenchDoesNotBridgeIt) {
  SurfacesWorld world;
  world.setEye({-2, 0, 1.2});
  world.addFloor(-3, -2, -0.3, 2);
  world.addFloor(0.3, -2, 3, 2);
  world.add({0.3, -2, -0.5}, {0, 4, 0}, {0, 0, 0.5});              // its far side
  world.addFloor(-1, -1, 1, 1, 0, 20, 2);                          // a first look from afar
  world.add({-0.3, -2, -0.5}, {0.6, 0, 0.2}, {0, 4, 0}, 60, 0.2);  // what was seen in it
  const CostGrid grid = world.grid();
  EXPECT_FALSE(isFree(grid, 0.05, 0.05));
  EXPECT_TRUE(isFree(grid, -1.05, 0.05));
}

TEST(CostGrid, AGlassPaneOfWhichAFewBeamsCameBackIsInTheWay) {
  SurfacesWorld world;
  world.setEye({-2, 0, 0.6});
  world.addFloor(-3, -2, 3, 2);
  world.add({0.05, -2, 0}, {0, 4, 0}, {0, 0, 2}, 2, 0.4);  // one beam in fifteen
  EXPECT_FALSE(isFree(world.grid(), 0.05, 0.05));
}

TEST(CostGrid, WhereTheRobotWalkedItCanWalk) {
  const auto steep = [](bool walked) {
    SurfacesWorld world;
    world.setEye({-2, 0, 0.6});
    world.add({-2, -1, 0}, {3, 0, 3 * std::tan(35 * kDegree)}, {0, 2, 0});  // steeper than the limit
    Map map = world.map();
    for (int k = 1; walked && k < 4; ++k) {
      MapUpdate update;
      const Vec3 p(-2 + k, 0, 0.6 + k * std::tan(35 * kDegree));
      update.keyframe = NewKeyframe{{k * 1'000'000, Pose(Eigen::Translation3d(p))}, {}};
      map.apply(std::move(update));
    }
    return buildCostGrid(map, *gridShape({-4, -4, 4, 4}, 0.1), {});
  };
  const double z = 1.55 * std::tan(35 * kDegree);
  EXPECT_FALSE(isFree(steep(false), -0.45, 0.05, z));
  EXPECT_TRUE(isFree(steep(true), -0.45, 0.05, z));
  EXPECT_FALSE(isFree(steep(true), -0.45, 0.75, z)) << "beside the way";
}

TEST(CostGrid, GapsUnderACeilingAreFilledAsWell) {
  SurfacesWorld world;
  for (int k = 0; k < 12; ++k) {
    world.add({-3 + 0.6 * k, -2, 0}, {0.4, 0, 0}, {0, 4, 0}, 30, 0.4);
  }
  world.addFloor(-3, -2, 3, 2, 2.5);
  const CostGrid grid = world.grid();
  ASSERT_NE(supportAt(grid, -2.45, 0.05), nullptr);
  EXPECT_TRUE(isFree(grid, -2.45, 0.05));
}

TEST(CostGrid, ADoubtfulObjectIsNotInTheWay) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  Map map = world.map();
  MapNode ghost = nodeAt(10, {0, 0, 0.5}, 0.2);
  ghost.classes = {};
  addViews(ghost.classes, {{10, 1.0F}, {0, 1000.0F}});
  addLeaf(ghost, packLeaf({Vec3::Zero(), 0.01 * Mat3::Identity(), 100}));
  ASSERT_FALSE(isConfirmed(ghost));
  MapUpdate update;
  update.created = {ghost};
  map.apply(std::move(update));
  const TraversabilityConfig limits;
  EXPECT_TRUE(isFree(buildCostGrid(map, *gridShape({-4, -4, 4, 4}, 0.1), limits), 0.05, 0.05));
}

TEST(CostGrid, TheSameMapGivesTheSameSurfacesAndAPartOfItTheSameInside) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  world.addSides(0.5, 0.5, 1, 1, 0, 1);
  const CostGrid whole = world.grid(), again = world.grid(), part = world.grid({-1, -1, 1.5, 1.5});
  ASSERT_EQ(whole.supports.size(), again.supports.size());
  for (std::int32_t row = 2; row < part.shape.height - 2; ++row) {
    for (std::int32_t column = 2; column < part.shape.width - 2; ++column) {
      const double x = part.shape.xOf(column), y = part.shape.yOf(row);
      EXPECT_EQ(costAt(part, x, y), costAt(whole, x, y)) << x << " " << y;
      EXPECT_EQ(costAt(again, x, y), costAt(whole, x, y));
    }
  }
}

TEST(GridShape, RefusesWhatIsNoGrid) {
  EXPECT_NE(gridShape({0, 0, 10, 10}, 0).error, "");
  EXPECT_NE(gridShape({0, 0, 10, 10}, 1e-9).error, "");
  EXPECT_NE(gridShape({0, 0, 10, 10}, std::nan("")).error, "");
  EXPECT_NE(gridShape({0, 0, 0, 10}, 0.1).error, "");
  EXPECT_NE(gridShape({0, 0, std::nan(""), 10}, 0.1).error, "");
  EXPECT_NE(gridShape({0, 0, 1e300, 10}, 0.1).error, "");
  EXPECT_NE(gridShape({-1e6, -1e6, 1e6, 1e6}, 0.1).error.find("resolution of"), std::string::npos);
  const Result<GridShape> fits = gridShape({-1.05, 2, 1, 3}, 0.1);
  ASSERT_TRUE(fits);
  EXPECT_EQ(fits->width, 21);
  EXPECT_EQ(fits->height, 10);
  EXPECT_NEAR(fits->x, -1.1, 1e-9);
}

}  // namespace
}  // namespace hgg::cost_grid_test
