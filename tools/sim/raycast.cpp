#include "sim/raycast.h"

#include <cmath>
#include <limits>

namespace hgg {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The stretch of a ray inside a convex set; empty when leave < enter.
struct Interval {
  double enter = -kInfinity, leave = kInfinity;
};

Interval both(const Interval& a, const Interval& b) { return {std::max(a.enter, b.enter), std::min(a.leave, b.leave)}; }

/// Where lo <= origin + t * direction <= hi.
Interval slab(double origin, double direction, double lo, double hi) {
  if (direction == 0.0) {
    return lo <= origin && origin <= hi ? Interval{} : Interval{kInfinity, -kInfinity};
  }
  const double a = (lo - origin) / direction, b = (hi - origin) / direction;
  return {std::min(a, b), std::max(a, b)};
}

/// Where the ray is within `radius` of the vertical line through `axis`.
Interval tube(const Vec3& axis, double radius, const Ray& ray) {
  const double ox = ray.origin.x() - axis.x(), oy = ray.origin.y() - axis.y();
  const double dx = ray.direction.x(), dy = ray.direction.y();
  const double a = dx * dx + dy * dy, b = ox * dx + oy * dy, c = ox * ox + oy * oy - radius * radius;
  if (a == 0.0) {
    return c <= 0.0 ? Interval{} : Interval{kInfinity, -kInfinity};
  }
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) {
    return {kInfinity, -kInfinity};
  }
  const double root = std::sqrt(discriminant);
  return {(-b - root) / a, (-b + root) / a};
}

std::optional<double> firstCrossing(const Interval& inside) {
  if (inside.leave < inside.enter || inside.leave <= 0.0) {
    return std::nullopt;
  }
  return inside.enter > 0.0 ? inside.enter : inside.leave;
}

/// False when no point of the solid can be hit nearer than `nearest`.
bool mayHit(const Solid& solid, const Ray& ray, double nearest) {
  const Vec3 to_center = solid.bound_center - ray.origin;
  const double along = to_center.dot(ray.direction);
  const double square = solid.bound_radius * solid.bound_radius;
  const bool passes_by = to_center.squaredNorm() - along * along > square;
  return !passes_by && along + solid.bound_radius > 0.0 && along - solid.bound_radius < nearest;
}

Vec3 normalAt(const Plane& plane, const Vec3& /*p*/) { return plane.normal; }

Vec3 normalAt(const Box& box, const Vec3& p) {
  const Vec3 local = box.T_world_box.inverse() * p;
  int axis = 0;
  (local.cwiseAbs() - box.half).maxCoeff(&axis);
  return box.T_world_box.linear().col(axis) * (local[axis] < 0.0 ? -1.0 : 1.0);
}

Vec3 normalAt(const Cylinder& cylinder, const Vec3& p) {
  const Vec3 from_middle = p - cylinder.base - 0.5 * cylinder.height * Vec3::UnitZ();
  const double out = std::hypot(from_middle.x(), from_middle.y());
  const bool on_cap = std::abs(from_middle.z()) - 0.5 * cylinder.height > out - cylinder.radius;
  return on_cap ? Vec3(0.0, 0.0, from_middle.z() < 0.0 ? -1.0 : 1.0)
                : Vec3(from_middle.x() / out, from_middle.y() / out, 0.0);
}

Vec3 normalAt(const Ellipsoid& ellipsoid, const Vec3& p) {
  return (p - ellipsoid.center).cwiseQuotient(ellipsoid.half.cwiseAbs2()).normalized();
}

Vec3 normalAt(const Triangle& triangle, const Vec3& /*p*/) {
  return (triangle.b - triangle.a).cross(triangle.c - triangle.a).normalized();
}

}  // namespace

std::optional<double> intersect(const Plane& plane, const Ray& ray) {
  const double speed = plane.normal.dot(ray.direction);
  const double range = plane.normal.dot(plane.point - ray.origin) / speed;
  return speed != 0.0 && range > 0.0 ? std::optional(range) : std::nullopt;
}

std::optional<double> intersect(const Box& box, const Ray& ray) {
  const Mat3 R_box_world = box.T_world_box.linear().transpose();
  const Vec3 origin = R_box_world * (ray.origin - box.T_world_box.translation());
  const Vec3 direction = R_box_world * ray.direction;
  Interval inside;
  for (int axis = 0; axis < 3; ++axis) {
    inside = both(inside, slab(origin[axis], direction[axis], -box.half[axis], box.half[axis]));
  }
  return firstCrossing(inside);
}

std::optional<double> intersect(const Cylinder& cylinder, const Ray& ray) {
  const double bottom = cylinder.base.z();
  return firstCrossing(both(tube(cylinder.base, cylinder.radius, ray),
                            slab(ray.origin.z(), ray.direction.z(), bottom, bottom + cylinder.height)));
}

std::optional<double> intersect(const Ellipsoid& ellipsoid, const Ray& ray) {
  // In the space where the ellipsoid is the unit sphere; the parameter along the ray stays the same.
  const Vec3 origin = (ray.origin - ellipsoid.center).cwiseQuotient(ellipsoid.half);
  const Vec3 direction = ray.direction.cwiseQuotient(ellipsoid.half);
  const double a = direction.squaredNorm(), b = origin.dot(direction), c = origin.squaredNorm() - 1.0;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) {
    return std::nullopt;
  }
  const double root = std::sqrt(discriminant);
  return firstCrossing({(-b - root) / a, (-b + root) / a});
}

std::optional<double> intersect(const Triangle& triangle, const Ray& ray) {
  // Moeller and Trumbore: barycentric coordinates by triple products.
  const Vec3 ab = triangle.b - triangle.a, ac = triangle.c - triangle.a, ao = ray.origin - triangle.a;
  const Vec3 across = ray.direction.cross(ac);
  const double determinant = ab.dot(across);
  const double u = ao.dot(across) / determinant;
  if (determinant == 0.0 || u < 0.0 || u > 1.0) {
    return std::nullopt;
  }
  const Vec3 up = ao.cross(ab);
  const double v = ray.direction.dot(up) / determinant, range = ac.dot(up) / determinant;
  return v >= 0.0 && u + v <= 1.0 && range > 0.0 ? std::optional(range) : std::nullopt;
}

Vec3 facingNormal(const Shape& shape, const Ray& ray, double range) {
  const Vec3 p = ray.origin + range * ray.direction;
  const Vec3 normal = std::visit([&](const auto& s) { return normalAt(s, p); }, shape);
  return normal.dot(ray.direction) > 0.0 ? Vec3(-normal) : normal;
}

std::optional<Hit> castRay(const World& world, const Ray& ray) {
  std::optional<Hit> nearest;
  for (std::size_t i = 0; i < world.solids.size(); ++i) {
    const Solid& solid = world.solids[i];
    if (!mayHit(solid, ray, nearest ? nearest->range : kInfinity)) {
      continue;
    }
    const auto range = std::visit([&](const auto& shape) { return intersect(shape, ray); }, solid.shape);
    if (range && (!nearest || *range < nearest->range)) {
      nearest = Hit{*range, solid.object, facingNormal(solid.shape, ray, *range), i};
    }
  }
  return nearest;
}

}  // namespace hgg
