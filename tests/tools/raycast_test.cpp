#include "sim/raycast.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/random.h"

namespace hgg::raycast_test {
namespace {

Pose poseAt(const Vec3& position, double angle, const Vec3& axis) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  return pose;
}

bool contains(const Box& box, const Vec3& p) {
  const Vec3 local = box.T_world_box.inverse() * p;
  return (local.cwiseAbs().array() <= box.half.array()).all();
}

bool contains(const Cylinder& c, const Vec3& p) {
  return std::hypot(p.x() - c.base.x(), p.y() - c.base.y()) <= c.radius && p.z() >= c.base.z() &&
         p.z() <= c.base.z() + c.height;
}

bool contains(const Ellipsoid& e, const Vec3& p) { return (p - e.center).cwiseQuotient(e.half).norm() <= 1.0; }

Ray randomRay(const RandomKey& key) {
  const Vec3 origin = 6.0 * Vec3(gaussian(key, 0), gaussian(key, 1), gaussian(key, 2));
  const Vec3 target = 1.5 * Vec3(gaussian(key, 3), gaussian(key, 4), gaussian(key, 5));
  return {origin, (target - origin).normalized()};
}

/// Walks along the ray in small steps and reports where it first changes sides.
template <typename Shape>
std::optional<double> march(const Shape& shape, const Ray& ray) {
  constexpr double kStep = 1e-3, kFar = 40.0;
  const bool starts_inside = contains(shape, ray.origin);
  for (double t = kStep; t < kFar; t += kStep) {
    if (contains(shape, ray.origin + t * ray.direction) != starts_inside) {
      return t;
    }
  }
  return std::nullopt;
}

template <typename Shape>
void expectAgreesWithMarching(const Shape& shape) {
  int hits = 0;
  for (std::uint64_t i = 0; i < 150; ++i) {
    const Ray ray = randomRay({17, i});
    const auto range = intersect(shape, ray), marched = march(shape, ray);
    if (marched) {
      ASSERT_TRUE(range) << "ray " << i;
      EXPECT_NEAR(*range, *marched, 1.1e-3) << "ray " << i;
      ++hits;
    } else if (range) {
      // Marching may step over a graze: then the chord is shorter than a step.
      EXPECT_FALSE(contains(shape, ray.origin + (*range + 1e-3) * ray.direction)) << "ray " << i;
    }
  }
  EXPECT_GT(hits, 30);
  EXPECT_LT(hits, 150);
}

TEST(Raycast, PlaneMatchesClosedForm) {
  const Plane ground{Vec3(0, 0, -1.5), Vec3::UnitZ()};
  const double down = 0.3;
  const auto range = intersect(ground, {Vec3(4, 5, 0.5), Vec3(std::cos(down), 0, -std::sin(down))});
  ASSERT_TRUE(range);
  EXPECT_NEAR(*range, 2.0 / std::sin(down), 1e-12);
}

TEST(Raycast, PlaneIsMissedUpwardsAndAlong) {
  const Plane ground{Vec3::Zero(), Vec3::UnitZ()};
  EXPECT_FALSE(intersect(ground, {Vec3(0, 0, 2), Vec3(0.6, 0, 0.8)}));
  EXPECT_FALSE(intersect(ground, {Vec3(0, 0, 2), Vec3::UnitX()}));
  EXPECT_FALSE(intersect(ground, {Vec3::Zero(), Vec3::UnitX()}));
}

TEST(Raycast, TurnedBoxMatchesClosedForm) {
  // A 2 m cube turned by 45 degrees shows its edge, sqrt(2) in front of its centre.
  const Box cube{poseAt(Vec3(10, 0, 0), M_PI / 4, Vec3::UnitZ()), Vec3(1, 1, 1)};
  const auto range = intersect(cube, {Vec3::Zero(), Vec3::UnitX()});
  ASSERT_TRUE(range);
  EXPECT_NEAR(*range, 10.0 - std::sqrt(2.0), 1e-12);
}

TEST(Raycast, BoxBehindIsMissedAndBoxAroundIsLeft) {
  const Box box{poseAt(Vec3(10, 0, 0), 0, Vec3::UnitZ()), Vec3(1, 2, 3)};
  EXPECT_FALSE(intersect(box, {Vec3::Zero(), -Vec3::UnitX()}));
  const auto leave = intersect(box, {Vec3(10, 0, 0), Vec3::UnitY()});
  ASSERT_TRUE(leave);
  EXPECT_DOUBLE_EQ(*leave, 2.0);
}

TEST(Raycast, CylinderMatchesClosedForm) {
  const Cylinder pole{Vec3(5, 0.3, -1), 0.5, 4.0};
  const auto side = intersect(pole, {Vec3::Zero(), Vec3::UnitX()});
  ASSERT_TRUE(side);
  EXPECT_NEAR(*side, 5.0 - 0.4, 1e-12);  // 0.3 off the axis of a 0.5 m cylinder: 3-4-5
  const auto cap = intersect(pole, {Vec3(5.1, 0.3, 10), -Vec3::UnitZ()});
  ASSERT_TRUE(cap);
  EXPECT_NEAR(*cap, 7.0, 1e-12);
  EXPECT_FALSE(intersect(pole, {Vec3(0, 0, 3.01), Vec3::UnitX()}));
  EXPECT_FALSE(intersect(pole, {Vec3(0, -0.21, 0), Vec3::UnitX()}));
}

TEST(Raycast, EllipsoidMatchesClosedForm) {
  const Ellipsoid crown{Vec3(10, 0, 3), Vec3(2, 2, 1)};
  EXPECT_NEAR(*intersect(crown, {Vec3(0, 0, 3), Vec3::UnitX()}), 8.0, 1e-12);
  EXPECT_NEAR(*intersect(crown, {Vec3(10, 0, 0), Vec3::UnitZ()}), 2.0, 1e-12);
  EXPECT_NEAR(*intersect(crown, {Vec3(10, 0, 3), Vec3::UnitX()}), 2.0, 1e-12);  // from inside
  EXPECT_FALSE(intersect(crown, {Vec3(0, 0, 4.01), Vec3::UnitX()}));
  EXPECT_FALSE(intersect(crown, {Vec3(0, 0, 3), -Vec3::UnitX()}));
}

TEST(Raycast, EllipsoidAgreesWithMarching) {
  expectAgreesWithMarching(Ellipsoid{Vec3(0.2, 0.1, -0.3), Vec3(1.5, 1.5, 0.8)});
}

TEST(Raycast, TriangleIsHitInsideItsEdgesFromBothSides) {
  const Triangle triangle{Vec3(0, 0, 1), Vec3(2, 0, 1), Vec3(0, 2, 1)};
  const auto above = intersect(triangle, {Vec3(0.5, 0.5, 4), -Vec3::UnitZ()});
  const auto below = intersect(triangle, {Vec3(0.5, 0.5, 0), Vec3::UnitZ()});
  ASSERT_TRUE(above && below);
  EXPECT_NEAR(*above, 3.0, 1e-12);
  EXPECT_NEAR(*below, 1.0, 1e-12);
  for (const Vec3& outside : {Vec3(1.2, 1.0, 4), Vec3(-0.1, 0.5, 4), Vec3(0.5, -0.1, 4)}) {
    EXPECT_FALSE(intersect(triangle, {outside, -Vec3::UnitZ()}));
  }
  EXPECT_FALSE(intersect(triangle, {Vec3(0.5, 0.5, 0), -Vec3::UnitZ()}));  // behind
  EXPECT_FALSE(intersect(triangle, {Vec3(-1, 0.5, 1), Vec3::UnitX()}));    // along its plane
}

TEST(Raycast, NormalsFaceTheRayAndArePerpendicularToTheSurface) {
  const Shape shapes[] = {Box{poseAt(Vec3(0, 0, 0), 0.5, Vec3(1, 1, 0)), Vec3(1, 2, 0.5)},
                          Cylinder{Vec3(0, 0, -1), 0.8, 2.0}, Ellipsoid{Vec3(0, 0, 0), Vec3(1.5, 1.5, 0.7)},
                          Triangle{Vec3(-3, -3, 0), Vec3(3, -3, 0.5), Vec3(0, 3, 1)},
                          Plane{Vec3(0, 0, -1), Vec3(0.1, 0.2, 1).normalized()}};
  constexpr double kNear = 1e-4;
  int compared = 0;
  for (const Shape& shape : shapes) {
    for (std::uint64_t i = 0; i < 60; ++i) {
      const Ray ray = randomRay({23, i});
      const auto cast = [&](const Ray& r) { return std::visit([&](const auto& s) { return intersect(s, r); }, shape); };
      const auto range = cast(ray);
      if (!range) {
        continue;
      }
      const Vec3 normal = facingNormal(shape, ray, *range), hit = ray.origin + *range * ray.direction;
      EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
      EXPECT_LE(normal.dot(ray.direction), 0.0);
      // The oracle: a step along the tangents stays on the surface to first order, unless it leaves over an edge.
      for (const Vec3& tangent : {normal.unitOrthogonal(), Vec3(normal.cross(normal.unitOrthogonal()))}) {
        const auto beside = cast({hit + kNear * tangent + 0.01 * normal, -normal});
        if (beside && std::abs(*beside - 0.01) < 1e-3) {
          EXPECT_NEAR(*beside, 0.01, 1e-6);
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 200);
}

TEST(Raycast, BoxAgreesWithMarching) {
  expectAgreesWithMarching(Box{poseAt(Vec3(0.5, -0.4, 0.2), 0.7, Vec3(1, 2, 3)), Vec3(1.5, 0.6, 1.0)});
}

TEST(Raycast, CylinderAgreesWithMarching) { expectAgreesWithMarching(Cylinder{Vec3(0.3, -0.2, -1.0), 0.8, 2.2}); }

TEST(Raycast, NearestHitWinsWhateverTheOrder) {
  World world;
  addObject(world, 50, false, {uprightBox(Vec3(20, 0, -2), Vec3(2, 2, 4), 0.0)});
  addObject(world, 80, true, {Cylinder{Vec3(10, 0, -2), 0.5, 4.0}});
  addObject(world, 40, false, {Plane{Vec3(0, 0, -2), Vec3::UnitZ()}});
  const auto hit = castRay(world, {Vec3::Zero(), Vec3::UnitX()});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->object, 1u);
  EXPECT_NEAR(hit->range, 9.5, 1e-12);
  EXPECT_FALSE(castRay(world, {Vec3::Zero(), Vec3::UnitZ()}));
}

TEST(Raycast, BoundsNeverHideAHit) {
  World world;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const RandomKey key{3, i};
    const Vec3 at = 8.0 * Vec3(gaussian(key, 0), gaussian(key, 1), gaussian(key, 2));
    const Vec3 size = Vec3(0.2, 0.2, 0.2) + 2.0 * Vec3(uniform(key, 10), uniform(key, 11), uniform(key, 12));
    addObject(world, 10, true, {Box{poseAt(at, 3.0 * uniform(key, 13), Vec3(1, -1, 2)), size}});
    addObject(world, 80, true, {Cylinder{at + Vec3(2, 0, 0), size.x(), size.z()}});
  }
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Ray ray = randomRay({4, i});
    std::optional<Hit> expected;
    for (const Solid& solid : world.solids) {
      const auto range = std::visit([&](const auto& shape) { return intersect(shape, ray); }, solid.shape);
      if (range && (!expected || *range < expected->range)) {
        expected = Hit{*range, solid.object};
      }
    }
    const auto hit = castRay(world, ray);
    ASSERT_EQ(hit.has_value(), expected.has_value()) << "ray " << i;
    if (hit) {
      EXPECT_EQ(hit->object, expected->object) << "ray " << i;
      EXPECT_EQ(hit->range, expected->range) << "ray " << i;
    }
  }
}

}  // namespace
}  // namespace hgg::raycast_test
