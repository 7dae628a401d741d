#pragma once

#include <string>
#include <variant>
#include <vector>

#include "core/types.h"

namespace hgg {

/// Surfaces in the world frame (z up).
struct Plane {
  Vec3 point, normal;
};
struct Box {
  Pose T_world_box;
  Vec3 half;  // half extents along the box's own axes
};
/// Upright, with caps.
struct Cylinder {
  Vec3 base;
  double radius, height;
};
using Shape = std::variant<Plane, Box, Cylinder>;

/// What the labels and the truth know of a thing in the world; one object may be made of several solids.
struct WorldObject {
  std::uint32_t id = 0;  // 1, 2, ... in the order they were added
  ClassId label = 0;
  bool thing = false;  // counted in the truth
};

struct Solid {
  Shape shape;
  std::size_t object = 0;  // index into World::objects
  Vec3 bound_center;       // sphere around the shape; the radius is infinite for a plane
  double bound_radius;
};

struct World {
  std::vector<WorldObject> objects;
  std::vector<Solid> solids;
};

/// Adds an object made of `shapes`.
void addObject(World& world, ClassId label, bool thing, const std::vector<Shape>& shapes);

/// A box standing on `base` (centre of its underside), turned about z.
Box uprightBox(const Vec3& base, const Vec3& size, double yaw);

}  // namespace hgg
