#include "query/scene.h"

#include <gtest/gtest.h>

#include "../traversability/surfaces_world.h"
#include "core/units.h"

namespace hgg::scene_test {
namespace {

/// A room of 6 x 4 m with a low wall in it, turned by `yaw`. The wall is the last node.
Map roomTurnedBy(double yaw) {
  const auto turned = [&](double x, double y, double z) -> Vec3 {
    return Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Vec3(x, y, z);
  };
  SurfacesWorld world;
  world.add(turned(-3, -2, 0), turned(6, 0, 0), turned(0, 4, 0));
  world.add(turned(-3, -2, 0), turned(6, 0, 0), turned(0, 0, 2));
  world.add(turned(-3, -2, 0), turned(0, 4, 0), turned(0, 0, 2));
  world.add(turned(1, 0, 0), turned(0, 1, 0), turned(0, 0, 0.8));
  return world.map();
}

TEST(Scene, BoxesLieAlongTheWallsHoweverTheMapIsTurned) {
  const SceneThing straight = sceneOf(roomTurnedBy(0)).things.back();
  EXPECT_NEAR(straight.half.y(), 0.5, 0.05);
  for (const double degrees : {10.0, 30.0, 44.0, 100.0, -20.0}) {
    const double yaw = degrees * kDegree;
    const QueryScene scene = sceneOf(roomTurnedBy(yaw));
    EXPECT_NEAR(std::remainder(scene.yaw - yaw, 90 * kDegree), 0, 0.02) << degrees;
    const Vec3 half = scene.things.back().half;
    EXPECT_NEAR(std::max(half.x(), half.y()), straight.half.y(), 0.02) << degrees;
    EXPECT_LT(std::min(half.x(), half.y()), 0.05) << degrees;
    EXPECT_NEAR(gapBetween(scene.things[2], scene.things.back()),
                gapBetween(sceneOf(roomTurnedBy(0)).things[2], straight), 0.03);
  }
}

TEST(Scene, WithoutWallsIsTurnedAsTheMapIs) {
  SurfacesWorld world;
  world.add({0, 0, 0}, {3, 3, 0}, {-1, 1, 0});
  EXPECT_EQ(sceneOf(world.map()).yaw, 0);
}

}  // namespace
}  // namespace hgg::scene_test
