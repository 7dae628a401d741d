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
  return findGoal(map, kBox, grid, limits, {0, 0, std::nullopt}, groundHeight(map, grid));
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

TEST(Goal, OfNothingIsNone) {
  SurfacesWorld world;
  world.addFloor(-2, -2, 2, 2);
  const Map map = world.map();
  const TraversabilityConfig limits;
  const CostGrid grid = buildCostGrid(map, *gridShape(*regionOf(map), limits.resolution), limits);
  EXPECT_FALSE(findGoal(map, 99, grid, limits, {0, 0, std::nullopt}, 0).found);
}

}  // namespace
}  // namespace hgg::goal_test
