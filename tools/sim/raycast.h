#pragma once

#include <optional>

#include "sim/world.h"

namespace hgg {

struct Ray {
  Vec3 origin;
  Vec3 direction;  // unit length
};

struct Hit {
  double range = 0;            // m along the ray
  std::size_t object = 0;      // index into World::objects
  Vec3 normal = Vec3::Zero();  // of the surface, towards the origin of the ray; unit length
  std::size_t solid = 0;       // index into World::solids
};

/// Distance to the first crossing of the surface ahead of the origin (from inside: where the ray leaves); nullopt when
/// the ray misses.
std::optional<double> intersect(const Plane& plane, const Ray& ray);
std::optional<double> intersect(const Box& box, const Ray& ray);
std::optional<double> intersect(const Cylinder& cylinder, const Ray& ray);
std::optional<double> intersect(const Ellipsoid& ellipsoid, const Ray& ray);
std::optional<double> intersect(const Triangle& triangle, const Ray& ray);

/// Unit normal at the point of the shape's surface that the ray meets at `range`, turned towards the ray's origin.
Vec3 facingNormal(const Shape& shape, const Ray& ray, double range);

/// The nearest hit; of equally near ones that of the solid added first. Tries every solid: the oracle for RayCaster.
std::optional<Hit> castRay(const World& world, const Ray& ray);

}  // namespace hgg
