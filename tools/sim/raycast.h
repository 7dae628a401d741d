#pragma once

#include <optional>

#include "sim/world.h"

namespace hgg {

struct Ray {
  Vec3 origin;
  Vec3 direction;  // unit length
};

struct Hit {
  double range = 0;        // m along the ray
  std::size_t object = 0;  // index into World::objects
};

/// Distance to the first crossing of the surface ahead of the origin (from inside: where the ray leaves); nullopt when
/// the ray misses.
std::optional<double> intersect(const Plane& plane, const Ray& ray);
std::optional<double> intersect(const Box& box, const Ray& ray);
std::optional<double> intersect(const Cylinder& cylinder, const Ray& ray);

/// The nearest hit.
std::optional<Hit> castRay(const World& world, const Ray& ray);

}  // namespace hgg
