#include "map/stuff_surface.h"

#include <gtest/gtest.h>

#include "test_scene.h"

namespace hgg::stuff_surface_test {
namespace {

constexpr double kFloor = 0.02;  // m

/// A patch of leaves 0.3 m apart over the rectangle between two corners, each flat along its normal (0: x, 2: z).
LocalObject patchOf(ClassId label, bool stuff, const Vec3& low, const Vec3& high, int normal) {
  LocalObject object;
  object.label = label, object.stuff = stuff;
  Mat3 cov = 0.01 * Mat3::Identity();
  cov(normal, normal) = 1e-4;
  const Vec3 step = Vec3::Constant(0.3);
  for (double x = low.x(); x <= high.x(); x += step.x()) {
    for (double y = low.y(); y <= high.y(); y += step.y()) {
      for (double z = low.z(); z <= high.z(); z += step.z()) {
        object.leaves.push_back({{x, y, z}, cov, 10});
      }
    }
  }
  object.belief = object.leaves[0];
  for (std::size_t k = 1; k < object.leaves.size(); ++k) {
    object.belief = merge(object.belief, object.leaves[k]);
  }
  return object;
}

LocalGraph wallAround() {
  LocalGraph local;
  local.objects.push_back(patchOf(kRoad, true, {5, -3, 0}, {5, -1, 2}, 0));
  local.objects.push_back(patchOf(kRoad, true, {5, 1, 0}, {5, 3, 2}, 0));
  return local;
}

TEST(ViewsOfPlane, APatchOfTheWallIsTheWallAtFirst) {
  EXPECT_GT(weightOf(viewsOfPlane(wallAround(), patchOf(kCar, false, {5, -0.8, 0}, {5, 0.8, 2}, 0), kFloor), kRoad),
            19);
}

TEST(ViewsOfPlane, WhatStandsBeforeTheWallIsNot) {
  EXPECT_TRUE(viewsOfPlane(wallAround(), patchOf(kCar, false, {4.7, -0.8, 0}, {4.7, 0.8, 2}, 0), kFloor).empty());
}

TEST(ViewsOfPlane, AThingOnTheGroundHasOnlyItsFeetInIt) {
  LocalGraph local;
  local.objects.push_back(patchOf(kRoad, true, {3, -3, 0}, {7, 3, 0}, 2));
  const double views =
      weightOf(viewsOfPlane(local, patchOf(kCar, false, {5, -0.6, 0}, {5, 0.6, 1.5}, 0), kFloor), kRoad);
  EXPECT_LT(views, 4);
}

TEST(ViewsOfPlane, WhereWallsMeetThereIsNoPlane) {
  LocalGraph local;
  local.objects.push_back(patchOf(kRoad, true, {5, -3, 0}, {5, -1, 2}, 0));
  local.objects.push_back(patchOf(kRoad, true, {4.5, 1.1, 0}, {5.5, 1.1, 2}, 1));
  EXPECT_TRUE(viewsOfPlane(local, patchOf(kCar, false, {5, -0.8, 0}, {5, 0.8, 2}, 0), kFloor).empty());
}

}  // namespace
}  // namespace hgg::stuff_surface_test
