#include "query/goal.h"

#include <gtest/gtest.h>

#include "../traversability/surfaces_world.h"

namespace hgg::goal_test {
namespace {

constexpr NodeId kBox = 2;  // the first thing after the floor

/// The goal for the box with its corner at (4, -0.5), from the origin, on a floor with whatever else `more` adds.
template <typename More>
Goal goalWith(More more) {
  SurfacesWorld world;
  world.setEye({0, 0, 0.6});
  world.addEye({6, 2, 0.6});
  world.addFloor(-2, -3, 8, 3);
  world.add({4, -0.5, 0}, {1, 0, 0}, {0, 0, 0.8});
  more(world);
  const Map map = world.map();
  const TraversabilityConfig limits;
  const Result<GridShape> shape = gridShape(*regionOf(map), limits.resolution);
  const CostGrid grid = buildCostGrid(map, *shape, limits);
  return findGoal(map, kBox, grid, limits, {});
}

TEST(Goal, IsNearTheSurfaceFacesItAndCanBeReached) {
  const Goal goal = goalWith([](SurfacesWorld&) {});
  ASSERT_TRUE(goal.found) << goal.reason;
  EXPECT_LE(goal.distance, kGoalReach);
  EXPECT_GT(goal.distance, 0.2);  // the footprint stays out of it
  const Eigen::Vector2d towards(4.5 - goal.position.x(), -0.5 - goal.position.y());
  EXPECT_GT(towards.normalized().dot(Eigen::Vector2d(std::cos(goal.yaw), std::sin(goal.yaw))), 0.99);
  ASSERT_FALSE(goal.path.empty());
  EXPECT_LT((goal.path.back() - goal.position).norm(), 0.15);
  EXPECT_LT(goal.path.front().norm(), 0.3);
}

TEST(Goal, BehindAWallIsTheNearestPoseThatCanBeReached) {
  const Goal goal = goalWith([](SurfacesWorld& world) { world.add({2.5, -3, 0}, {0, 6, 0}, {0, 0, 2}); });
  ASSERT_TRUE(goal.found) << goal.reason;
  EXPECT_GT(goal.distance, kGoalReach);
  EXPECT_LT(goal.position.x(), 2.5);
  EXPECT_NE(goal.reason.find("reached"), std::string::npos);
}

TEST(Goal, HasRoomForTheRobot) {
  const Goal goal = goalWith([](SurfacesWorld& world) { world.add({3.3, -3, 0}, {0, 6, 0}, {0, 0, 2}); });
  ASSERT_TRUE(goal.found) << goal.reason;
  EXPECT_GT(std::abs(goal.position.x() - 3.3), TraversabilityConfig{}.footprint_radius);
}

TEST(Goal, IsNearTheSurfaceOfAThingThatStandsAtAnAngle) {
  SurfacesWorld world;
  world.setEye({0, 0, 0.6});
  world.addFloor(-2, -4, 8, 4);
  world.add({4, -1.5, 0}, {2, 2, 0}, {0, 0, 0.8}, 30, 1.5);  // in few leaves, as from far off
  const Map map = world.map();
  const Goal goal = findGoalInMap(map, kBox, {}, {}, kMaxGridCells);
  ASSERT_TRUE(goal.isAtThing()) << goal.reason;
  const double along = (goal.position.head<2>() - Eigen::Vector2d(4, -1.5)).dot(Eigen::Vector2d(1, 1).normalized());
  EXPECT_GT(along, -kGoalReach);
  EXPECT_LT(along, std::hypot(2, 2) + kGoalReach);
  const double off = std::abs(goal.position.x() - goal.position.y() - 5.5) / std::sqrt(2);
  EXPECT_LE(off, kGoalReach);
  EXPECT_NEAR(off, goal.distance, 0.15);
}

/// A long hall with a wall across it, which can be passed far from the straight way only.
SurfacesWorld hallWithADetour() {
  SurfacesWorld world;
  world.setEye({0, 0, 0.6});
  for (const double y : {0.0, 5.0, 10.0}) {
    world.addEye({0, y, 0.6});
    world.addEye({6, y, 0.6});
  }
  world.addFloor(-2, -2, 9, 12);
  world.add({5, -0.5, 0}, {1, 0, 0}, {0, 0, 0.8});
  world.add({3, -2, 0}, {0, 12, 0}, {0, 0, 2});
  return world;
}

TEST(Goal, WhereGroundIsLaidForItIsAsOnAllOfTheGround) {
  const Map map = hallWithADetour().map();
  const TraversabilityConfig limits;
  const CostGrid grid = buildCostGrid(map, *gridShape(*regionOf(map), limits.resolution), limits);
  const Goal whole = findGoal(map, kBox, grid, limits, {});
  const Goal laid = findGoalInMap(map, kBox, limits, {}, kMaxGridCells);
  ASSERT_TRUE(whole.isAtThing()) << whole.reason;
  ASSERT_TRUE(laid.isAtThing()) << laid.reason;
  EXPECT_GT(laid.path_length, 18) << "around the end of the wall, 10 m off";
  EXPECT_NEAR(laid.path_length, whole.path_length, 0.5);
}

TEST(Goal, OnGroundThatIsTooLargeToLayIsRefused) {
  const Map map = hallWithADetour().map();
  const Goal goal = findGoalInMap(map, kBox, {}, {}, 100);
  EXPECT_FALSE(goal.found);
  EXPECT_FALSE(goal.reason.empty());
}

TEST(Goal, OfNothingIsNone) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  const Map map = world.map();
  const TraversabilityConfig limits;
  const CostGrid grid = buildCostGrid(map, *gridShape(*regionOf(map), limits.resolution), limits);
  EXPECT_FALSE(findGoal(map, 99, grid, limits, {}).found);
}

}  // namespace
}  // namespace hgg::goal_test
