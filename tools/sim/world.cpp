#include "sim/world.h"

#include <limits>

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

}  // namespace

void addObject(World& world, ClassId label, bool thing, const std::vector<Shape>& shapes) {
  const std::size_t index = world.objects.size();
  world.objects.push_back({static_cast<std::uint32_t>(index + 1), label, thing});
  for (const Shape& shape : shapes) {
    const Sphere bound = std::visit([](const auto& s) { return boundOf(s); }, shape);
    world.solids.push_back({shape, index, bound.center, bound.radius});
  }
}

Box uprightBox(const Vec3& base, const Vec3& size, double yaw) {
  Pose pose = Pose::Identity();
  pose.translation() = base + Vec3(0, 0, size.z() / 2.0);
  pose.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  return {pose, size / 2.0};
}

}  // namespace hgg
