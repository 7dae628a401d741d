#include "sim/raycaster.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/random.h"

namespace hgg::raycaster_test {
namespace {

Vec3 randomVector(const RandomKey& key, std::uint64_t first) {
  return {gaussian(key, first), gaussian(key, first + 1), gaussian(key, first + 2)};
}

/// Every kind of shape, many of them, some equal, some touching.
World crowd() {
  World world;
  addObject(world, 40, false, {Plane{Vec3(0, 0, -6), Vec3::UnitZ()}});
  for (std::uint64_t i = 0; i < 150; ++i) {
    const RandomKey key{3, i};
    const Vec3 at = 12.0 * randomVector(key, 0);
    const Vec3 half = Vec3::Constant(0.1) + Vec3(uniform(key, 10), uniform(key, 11), uniform(key, 12));
    Pose pose = Pose::Identity();
    pose.translation() = at;
    pose.linear() = Eigen::AngleAxisd(3.0 * uniform(key, 13), randomVector(key, 3).normalized()).toRotationMatrix();
    addObject(world, 10, true, {Box{pose, half}, Ellipsoid{at + Vec3(0, 3, 0), half}, Box{pose, half}});
    addObject(world, 80, true, {Cylinder{at + Vec3(2, 0, 0), half.x(), half.z()}});
    addObject(world, 72, true, {Triangle{at, at + randomVector(key, 6), at + randomVector(key, 9)}});
  }
  return world;
}

Ray randomRay(const RandomKey& key, double spread) {
  return {spread * randomVector(key, 0), randomVector(key, 3).normalized()};
}

void expectSameHit(const std::optional<Hit>& hit, const std::optional<Hit>& expected, std::uint64_t i) {
  ASSERT_EQ(hit.has_value(), expected.has_value()) << "ray " << i;
  if (hit) {
    EXPECT_EQ(hit->range, expected->range) << "ray " << i;
    EXPECT_EQ(hit->object, expected->object) << "ray " << i;
    EXPECT_EQ(hit->solid, expected->solid) << "ray " << i;
    EXPECT_EQ(hit->normal, expected->normal) << "ray " << i;
  }
}

TEST(RayCaster, IsIdenticalToBruteForceInACrowd) {
  Scene scene;
  scene.world = crowd();
  const RayCaster caster(scene);
  int hits = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    const Ray ray = randomRay({4, i}, 8.0);
    const auto hit = caster.cast(ray);
    expectSameHit(hit, castRay(scene.world, ray), i);
    hits += hit && hit->object != 0 ? 1 : 0;
  }
  EXPECT_GT(hits, 400);
}

TEST(RayCaster, IsIdenticalToBruteForceAlongTheAxes) {
  Scene scene;
  scene.world = crowd();
  const RayCaster caster(scene);
  for (std::uint64_t i = 0; i < 600; ++i) {
    Ray ray = randomRay({5, i}, 8.0);
    ray.direction = (i % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(static_cast<Eigen::Index>(i % 3));
    expectSameHit(caster.cast(ray), castRay(scene.world, ray), i);
  }
}

TEST(RayCaster, IsIdenticalToBruteForceInEveryWorld) {
  for (const std::string& name : sceneNames()) {
    const Scene scene = *makeScene(name, 3);
    const RayCaster caster(scene);
    for (std::uint64_t i = 0; i < 400; ++i) {
      const RandomKey key{6, i};
      const Pose T_world_body = scene.T_world_body(scene.duration * uniform(key, 20));
      const Ray ray{T_world_body.translation(),
                    (Vec3(gaussian(key, 0), gaussian(key, 1), 0.3 * gaussian(key, 2))).normalized()};
      expectSameHit(caster.cast(ray), castRay(scene.world, ray), i);
    }
  }
}

TEST(RayCaster, AHitBeyondTheRangeIsNone) {
  Scene scene;
  addObject(scene.world, 50, false, {uprightBox(Vec3(10, 0, -1), Vec3(2, 2, 2), 0.0)});
  const RayCaster caster(scene);
  EXPECT_FALSE(caster.cast({Vec3::Zero(), Vec3::UnitX()}, 8.99));
  EXPECT_TRUE(caster.cast({Vec3::Zero(), Vec3::UnitX()}, 9.01));
}

/// A box that drives along y at 1 m/s and turns, in front of a wall.
Scene drivingBox() {
  Scene scene;
  addObject(scene.world, 50, false, {uprightBox(Vec3(20, 0, -5), Vec3(1, 60, 10), 0.0)});
  const std::size_t box = addObject(scene.world, 10, true, {uprightBox(Vec3(10, 0, -1), Vec3(2, 2, 2), 0.0)});
  scene.motions.push_back({box, [](double time) -> std::optional<Pose> {
                             if (time > 5.0) {
                               return std::nullopt;
                             }
                             Pose pose = Pose::Identity();
                             pose.translation() = Vec3(0, time, 0);
                             return pose;
                           }});
  return scene;
}

TEST(RayCaster, WhatMovesIsHitWhereItIsAtTheTime) {
  const Scene scene = drivingBox();
  RayCaster caster(scene);
  const Ray ahead{Vec3::Zero(), Vec3::UnitX()}, aside{Vec3(0, 3, 0), Vec3::UnitX()};
  EXPECT_NEAR(caster.cast(ahead)->range, 9.0, 1e-12);
  EXPECT_EQ(caster.cast(aside)->object, 0u);
  caster.setTime(3.0);
  EXPECT_EQ(caster.cast(ahead)->object, 0u);
  EXPECT_NEAR(caster.cast(aside)->range, 9.0, 1e-12);
  EXPECT_EQ(caster.cast(aside)->object, 1u);
}

TEST(RayCaster, WhatIsGoneIsNotHit) {
  const Scene scene = drivingBox();
  RayCaster caster(scene);
  caster.setTime(6.0);
  const auto hit = caster.cast({Vec3(0, 6, 0), Vec3::UnitX()});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->object, 0u);
}

TEST(RayCaster, MovedSolidsEqualSolidsAddedThere) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(1, -2, 0.5);
  T.linear() = Eigen::AngleAxisd(0.8, Vec3::UnitZ()).toRotationMatrix();
  Scene moving, there;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const RandomKey key{8, i};
    const Vec3 base = 4.0 * randomVector(key, 0), size = Vec3(0.5, 0.5, 0.5) + Vec3(uniform(key, 9), 0, 1);
    const Box box = uprightBox(base, size, uniform(key, 10));
    moving.motions.push_back({addObject(moving.world, 10, true, {box}), [T](double) { return std::optional(T); }});
    addObject(there.world, 10, true, {Box{T * box.T_world_box, box.half}});
  }
  const RayCaster caster(moving);
  int hits = 0;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Ray ray = randomRay({9, i}, 5.0);
    const auto hit = caster.cast(ray), expected = castRay(there.world, ray);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << "ray " << i;
    if (hit) {
      EXPECT_NEAR(hit->range, expected->range, 1e-9);
      EXPECT_EQ(hit->object, expected->object);
      EXPECT_TRUE(hit->normal.isApprox(expected->normal, 1e-9));
      ++hits;
    }
  }
  EXPECT_GT(hits, 50);
}

TEST(RayCaster, TellsWhereARayLeavesTheSolid) {
  Scene scene;
  addObject(scene.world, 70, false, {Ellipsoid{Vec3(10, 0, 0), Vec3(2, 2, 2)}});
  const RayCaster caster(scene);
  const Ray ray{Vec3::Zero(), Vec3::UnitX()};
  EXPECT_NEAR(caster.leavesAt(ray, *caster.cast(ray)), 12.0, 1e-6);
}

TEST(RayCaster, AnEmptySceneIsMissed) {
  const Scene scene;
  EXPECT_FALSE(RayCaster(scene).cast({Vec3::Zero(), Vec3::UnitX()}));
}

}  // namespace
}  // namespace hgg::raycaster_test
