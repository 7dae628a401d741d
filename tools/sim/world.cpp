#include "sim/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hgg {
namespace {

struct Sphere {
  Vec3 center;
  double radius;
};

Sphere boundOf(const Plane& plane) { return {plane.point, std::numeric_limits<double>::infinity()}; }
Sphere boundOf(const Box& box) { return {box.T_world_box.translation(), box.half.norm()}; }
Sphere boundOf(const Cylinder& cylinder) {
  const double half_height = cylinder.height / 2.0;
  return {cylinder.base + half_height * Vec3::UnitZ(), std::hypot(cylinder.radius, half_height)};
}

Sphere boundOf(const Ellipsoid& ellipsoid) { return {ellipsoid.center, ellipsoid.half.maxCoeff()}; }
Sphere boundOf(const Triangle& triangle) {
  const Vec3 center = (triangle.a + triangle.b + triangle.c) / 3.0;
  const double square = std::max(
      {(triangle.a - center).squaredNorm(), (triangle.b - center).squaredNorm(), (triangle.c - center).squaredNorm()});
  return {center, std::sqrt(square)};
}

Bounds around(const Plane& /*plane*/) {
  const Vec3 infinity = Vec3::Constant(std::numeric_limits<double>::infinity());
  return {-infinity, infinity};
}
Bounds around(const Box& box) {
  const Vec3 half = box.T_world_box.linear().cwiseAbs() * box.half;
  return {box.T_world_box.translation() - half, box.T_world_box.translation() + half};
}
Bounds around(const Cylinder& cylinder) {
  const Vec3 side(cylinder.radius, cylinder.radius, 0.0);
  return {cylinder.base - side, cylinder.base + side + cylinder.height * Vec3::UnitZ()};
}
Bounds around(const Ellipsoid& ellipsoid) {
  return {ellipsoid.center - ellipsoid.half, ellipsoid.center + ellipsoid.half};
}
Bounds around(const Triangle& triangle) {
  return {triangle.a.cwiseMin(triangle.b).cwiseMin(triangle.c), triangle.a.cwiseMax(triangle.b).cwiseMax(triangle.c)};
}

}  // namespace

std::size_t addObject(World& world, WorldObject object, const std::vector<Shape>& shapes) {
  const std::size_t index = world.objects.size();
  object.id = static_cast<std::uint32_t>(index + 1);
  world.objects.push_back(std::move(object));
  for (const Shape& shape : shapes) {
    addSolid(world, index, shape);
  }
  return index;
}

std::size_t addObject(World& world, ClassId label, bool thing, const std::vector<Shape>& shapes) {
  return addObject(world, WorldObject{.label = label, .thing = thing, .name = {}}, shapes);
}

void addSolid(World& world, std::size_t object, const Shape& shape) {
  const Sphere bound = std::visit([](const auto& s) { return boundOf(s); }, shape);
  world.solids.push_back({shape, object, bound.center, bound.radius});
}

Bounds boundsOf(const Shape& shape) {
  return std::visit([](const auto& s) { return around(s); }, shape);
}

Box uprightBox(const Vec3& base, const Vec3& size, double yaw) {
  Pose pose = Pose::Identity();
  pose.translation() = base + Vec3(0, 0, size.z() / 2.0);
  pose.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  return {pose, size / 2.0};
}

}  // namespace hgg
