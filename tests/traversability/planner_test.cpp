#include "traversability/planner.h"

#include <gtest/gtest.h>

#include "surfaces_world.h"

namespace hgg::planner_test {
namespace {

PlanRequest request(double x0, double y0, double x1, double y1) {
  PlanRequest r;
  r.from = {x0, y0, std::nullopt}, r.to = {x1, y1, std::nullopt};
  return r;
}

/// A floor of 6 x 4 m and what is unknown around it, cut in two by a wall at x = 0, with a gap from y = 0 to `gap`.
SurfacesWorld wallWithGap(double gap) {
  SurfacesWorld world;
  world.setEye({-1.5, 0, 0.6});
  world.addEye({1.5, 0, 0.6});
  world.addFloor(-3, -2, 3, 2);
  world.add({0, -4, 0}, {0, 4, 0}, {0, 0, 2});
  world.add({0, gap, 0}, {0, 4 - gap, 0}, {0, 0, 2});
  return world;
}

TEST(Planner, OnOpenGroundThePathIsStraight) {
  SurfacesWorld world;
  world.addFloor(-3, -2, 3, 2);
  const Plan plan = planPath(world.grid(), {}, request(-2, -1, 2, 1.2));
  ASSERT_TRUE(plan.found) << plan.reason;
  EXPECT_LT(plan.length, 1.03 * std::hypot(4, 2.2));
  EXPECT_GE(plan.cost, plan.length * 0.99);
  EXPECT_GT(plan.worst_confidence, 0.9);
  EXPECT_EQ(plan.path.front().x(), -2);
  EXPECT_EQ(plan.path.back().y(), 1.2);
}

TEST(Planner, GoesThroughADoorwayOfNinetyCentimetres) {
  const Plan plan = planPath(wallWithGap(0.9).grid(), {}, request(-2, -1, 2, -1));
  ASSERT_TRUE(plan.found) << plan.reason;
  EXPECT_LT(plan.length, 1.1 * 2 * std::hypot(2, 1.4));
}

TEST(Planner, DoesNotSqueezeThroughAGapNarrowerThanTheRobot) {
  const Plan plan = planPath(wallWithGap(0.3).grid(), {}, request(-2, -1, 2, -1));
  EXPECT_FALSE(plan.found);
  EXPECT_NE(plan.reason.find("obstacles"), std::string::npos) << plan.reason;
}

TEST(Planner, WhereTheRobotWalkedItHasRoomThoughAPointBesideItsWaySaysNot) {
  const auto doorway = [](bool walked) {
    SurfacesWorld world;
    world.addFloor(-3, -2, 3, 2);
    world.add({0, -4, 0}, {0, 3.75, 0}, {0, 0, 2});
    world.add({0, 0.25, 0}, {0, 3.75, 0}, {0, 0, 2});
    world.add({-0.05, 0.15, 0}, {0.1, 0, 0}, {0, 0, 1});  // in a doorway of half a metre
    world.setEye({-1.2, 0.05, 0.6});
    Map map = world.map();
    for (int k = 1; walked && k < 3; ++k) {
      MapUpdate update;
      update.keyframe = NewKeyframe{{k * 1'000'000, Pose(Eigen::Translation3d(-1.2 + 1.2 * k, 0.05, 0.6))}, {}};
      map.apply(std::move(update));
    }
    return planPath(buildCostGrid(map, *gridShape({-4, -4, 4, 4}, 0.1), {}), {}, request(-2, -1, 2, -1));
  };
  EXPECT_FALSE(doorway(false).found);
  const Plan plan = doorway(true);
  EXPECT_TRUE(plan.found) << plan.reason;
}

TEST(Planner, EveryPlaceOfAPathIsFreeWithTheFootprintAroundIt) {
  SurfacesWorld world = wallWithGap(0.9);
  world.addSides(-1.2, -0.5, -0.9, 0.4, 0, 1);
  const CostGrid grid = world.grid();
  const Plan plan = planPath(grid, {}, request(-2, -1, 2, -1));
  ASSERT_TRUE(plan.found) << plan.reason;
  for (std::size_t k = 1; k < plan.path.size(); ++k) {
    for (double t = 0; t <= 1; t += 0.01) {
      const Vec3 p = (1 - t) * plan.path[k - 1] + t * plan.path[k];
      EXPECT_TRUE(isFree(grid, p.x(), p.y())) << p.transpose();
      // Half a cell of the footprint is lost to the cells.
      EXPECT_TRUE(std::abs(p.x()) > 0.1 || (p.y() > 0.2 && p.y() < 0.7)) << p.transpose();
    }
  }
}

TEST(Planner, ClimbsStairs) {
  SurfacesWorld world;
  world.setEye({-2, 0, 3});
  world.addFloor(-3, -1, 0, 1);
  for (int k = 0; k < 6; ++k) {  // treads of 0.3 m, risers of 0.16 m
    world.add({0.3 * k, -1, 0.16 * k}, {0, 2, 0}, {0, 0, 0.16});
    world.addFloor(0.3 * k, -1, 0.3 * (k + 1), 1, 0.16 * (k + 1));
  }
  world.addFloor(1.8, -1, 3.5, 1, 0.96);
  PlanRequest up = request(-2, 0, 3, 0);
  up.to.z = 0.96;
  const Plan plan = planPath(world.grid(), {}, up);
  ASSERT_TRUE(plan.found) << plan.reason;
  EXPECT_NEAR(plan.path.back().z(), 0.96, 0.03);
  TraversabilityConfig low;
  low.step_height = 0.1;
  EXPECT_FALSE(planPath(world.grid({-4, -4, 4, 4}, low), low, up).found);
}

TEST(Planner, WalksUnderABridgeAndOverIt) {
  SurfacesWorld world;
  world.setEye({0, 0, 4});
  world.addEye({0, -2.5, 0.6});
  world.addEye({0, 2.5, 0.6});
  world.addFloor(-3, -3, 3, 3);
  world.addFloor(-3, -0.8, 3, 0.8, 2);
  const CostGrid grid = world.grid();
  PlanRequest under = request(0, -2, 0, 2), over = request(-2, 0, 2, 0), across = request(-2, 0, 0, 2);
  over.from.z = over.to.z = across.from.z = 2.0;
  across.to.z = 0;
  const Plan low = planPath(grid, {}, under), high = planPath(grid, {}, over);
  ASSERT_TRUE(low.found) << low.reason;
  ASSERT_TRUE(high.found) << high.reason;
  EXPECT_NEAR(low.path[low.path.size() / 2].z(), 0, 0.05);
  EXPECT_NEAR(high.path.back().z(), 2, 0.05);
  EXPECT_FALSE(planPath(grid, {}, across).found) << "nobody jumps from the bridge";
}

TEST(Planner, AvoidsAShortcutOverGroundThatIsHardlyKnown) {
  SurfacesWorld world;
  world.addFloor(-3, -2, -1, 2, 0, 12);
  world.addFloor(1, -2, 3, 2, 0, 12);
  world.addFloor(-1, 0.2, 1, 2, 0, 12);  // the way around
  SurfacesWorld known = world;
  world.addFloor(-1, -2, 1, 0.2, 0, 0.7, 0.4);  // the shortcut
  known.addFloor(-1, -2, 1, 0.2, 0, 12);
  const Plan around = planPath(world.grid(), {}, request(-2, -0.5, 2, -0.5));
  const Plan direct = planPath(known.grid(), {}, request(-2, -0.5, 2, -0.5));
  ASSERT_TRUE(around.found && direct.found) << around.reason << direct.reason;
  ASSERT_LT(supportAt(world.grid(), 0.05, -0.55)->confidence, 0.75);
  ASSERT_TRUE(isFree(world.grid(), 0.05, -0.55));
  EXPECT_GT(around.worst_confidence, 0.8);
  EXPECT_LT(direct.length, 4.1);
  EXPECT_GT(around.length, direct.length + 0.3);
}

TEST(Planner, StopsAtUnknownGroundUnlessItIsAllowed) {
  SurfacesWorld world;
  world.addFloor(-3, -2, -1, 2);
  world.addFloor(1, -2, 3, 2);
  PlanRequest r = request(-2, 0, 2, 0);
  const Plan careful = planPath(world.grid(), {}, r);
  EXPECT_FALSE(careful.found);
  EXPECT_NE(careful.reason.find("unknown ground"), std::string::npos) << careful.reason;
  r.allow_unknown = true;
  const Plan bold = planPath(world.grid(), {}, r);
  ASSERT_TRUE(bold.found) << bold.reason;
  EXPECT_EQ(bold.worst_confidence, 0);
}

TEST(Planner, SaysWhyThereIsNoPath) {
  SurfacesWorld world;
  world.addFloor(-3, -2, 3, 2);
  world.addSides(0.5, 0.5, 1, 1, 0, 0.45);
  world.addFloor(0.5, 0.5, 1, 1, 0.45);
  const CostGrid grid = world.grid();
  const auto reason = [&](const PlanRequest& r) { return planPath(grid, {}, r).reason; };
  EXPECT_NE(reason(request(0.75, 0.75, -2, 0)).find("the start (0.75, 0.75) lies in an obstacle"), std::string::npos)
      << reason(request(0.75, 0.75, -2, 0));
  EXPECT_NE(reason(request(-2, 0, -3.5, 0)).find("the goal (-3.50, 0.00) lies on unknown ground"), std::string::npos);
  EXPECT_NE(reason(request(-2, 0, 300, 0)).find("outside"), std::string::npos);
  PlanRequest high = request(-2, 0, -1, 0);
  high.from.z = 8;
  EXPECT_NE(reason(high).find("no ground within"), std::string::npos);
}

/// A floor of which hardly anything is known from x = 2 on.
CostGrid floorWithThinEnd() {
  SurfacesWorld world;
  world.addFloor(-3, -2, 2, 2, 0, 3);
  world.addFloor(2, -2, 3.5, 2, 0, 0.08, 0.5);
  TraversabilityConfig careful;
  careful.min_confidence = 0.3;
  return world.grid({-4, -4, 4, 4}, careful);
}

TEST(Planner, AGoalAStepBeyondWhatIsKnownIsWalkedUpToAndOneFartherOffIsRefused) {
  const CostGrid grid = floorWithThinEnd();
  const Plan plan = planPath(grid, {}, request(-2, 0, 2.15, 0.05));
  ASSERT_TRUE(plan.found) << plan.reason;
  EXPECT_TRUE(isFree(grid, plan.path.back().x(), plan.path.back().y()));
  EXPECT_NEAR(plan.goal_distance, std::hypot(plan.path.back().x() - 2.15, plan.path.back().y() - 0.05), 1e-9);
  EXPECT_GT(plan.goal_distance, 0.15);
  EXPECT_LT(plan.goal_distance, 0.5);
  EXPECT_FALSE(planPath(grid, {}, request(-2, 0, 2.75, 0.05)).found);
  PlanRequest exact = request(-2, 0, 2.15, 0.05);
  exact.tolerance = 0;
  EXPECT_FALSE(planPath(grid, {}, exact).found);
}

TEST(Planner, FromGroundThatIsHardlyKnownThePathBeginsWhereTheRobotStands) {
  const Plan plan = planPath(floorWithThinEnd(), {}, request(2.15, 0.05, -2, 0));
  ASSERT_TRUE(plan.found) << plan.reason;
  EXPECT_EQ(plan.path.front().x(), 2.15);
  EXPECT_EQ(plan.goal_distance, 0);
  EXPECT_NEAR(plan.length, 4.15, 0.1);
}

TEST(Planner, NoPathBeginsOrEndsOnTheOtherSideOfAWall) {
  // The strip behind the wall is too narrow for the robot: what is near and clear lies on the wall's other side.
  SurfacesWorld world;
  world.addFloor(-3, -2, 0.3, 2);
  world.add({0, -4, 0}, {0, 8, 0}, {0, 0, 2});
  EXPECT_FALSE(planPath(world.grid(), {}, request(-2, 0, 0.2, 0)).found);
  EXPECT_FALSE(planPath(world.grid(), {}, request(0.2, 0, -2, 0)).found);
}

/// The surface of the grid at a place.
std::uint32_t surfaceAt(const CostGrid& grid, double x, double y) {
  return grid.first[static_cast<std::size_t>(grid.shape.cell(grid.shape.columnOf(x), grid.shape.rowOf(y)))];
}

TEST(Planner, OfSeveralEndsTheCheapestIsTakenWithItsPenalty) {
  SurfacesWorld world;
  world.addFloor(-3, -2, 3, 2);
  const CostGrid grid = world.grid();
  const std::uint32_t near = surfaceAt(grid, 0.55, 0.05), far = surfaceAt(grid, 2.05, 0.05);
  const PlanPoint from{-2, 0.05, std::nullopt};
  for (const double penalty : {0.0, 1.2, 1.8}) {  // m; the far one is 1.5 m farther
    const PlanToAny way = planToAny(grid, {}, from, 0, std::vector<PlanEnd>{{far, 0}, {near, penalty}});
    ASSERT_TRUE(way.plan.found) << way.plan.reason;
    EXPECT_EQ(way.end, penalty < 1.5 ? 1U : 0U);
    EXPECT_NEAR(way.plan.path.back().x(), penalty < 1.5 ? 0.55 : 2.05, 0.06);
  }
}

TEST(Planner, AnEndAmongSeveralIsReachedByTheSameWayAsAlone) {
  const CostGrid grid = wallWithGap(0.9).grid();
  const PlanPoint from{-2, -1, std::nullopt};
  const PlanToAny any = planToAny(grid, {}, from, 0, std::vector<PlanEnd>{{surfaceAt(grid, 2.05, -1.05), 0}});
  const Plan alone = planPath(grid, {}, request(-2, -1, 2.05, -1.05));
  ASSERT_TRUE(any.plan.found && alone.found);
  EXPECT_NEAR(any.plan.cost, alone.cost, 1e-3);
  EXPECT_NEAR(any.plan.length, alone.length, 0.1);
}

TEST(Planner, NoEndBeyondAWallIsReached) {
  const CostGrid grid = wallWithGap(0.3).grid();
  const PlanToAny way =
      planToAny(grid, {}, {-2, -1, std::nullopt}, 0, std::vector<PlanEnd>{{surfaceAt(grid, 2.05, 0), 0}});
  EXPECT_FALSE(way.plan.found);
  EXPECT_FALSE(way.plan.reason.empty());
  EXPECT_FALSE(planToAny(grid, {}, {-2, -1, std::nullopt}, 0, {}).plan.found) << "no end at all";
  EXPECT_NE(planToAny(grid, {}, {-90, -1, std::nullopt}, 0, {}).plan.reason.find("outside"), std::string::npos);
}

}  // namespace
}  // namespace hgg::planner_test
