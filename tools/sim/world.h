#pragma once

#include <string>
#include <variant>
#include <vector>

#include "core/types.h"
#include "sim/bvh.h"

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
/// Half axes along x, y, z of the world.
struct Ellipsoid {
  Vec3 center, half;
};
/// Seen from both sides.
struct Triangle {
  Vec3 a, b, c;
};
using Shape = std::variant<Plane, Box, Cylinder, Ellipsoid, Triangle>;

/// What the labels and the truth know of a thing in the world; one object may be made of several solids.
struct WorldObject {
  std::uint32_t id = 0;  // 1, 2, ... in the order they were added
  ClassId label = 0;
  bool thing = false;         // counted in the truth
  bool dynamic = false;       // moves by itself while it is seen: no single true position
  bool foliage = false;       // rays scatter inside: tree crowns, bushes, plants
  ClassId confused_with = 0;  // what a segmenter mistakes the whole object for; 0 = nothing in particular
  std::string name = {};      // of the class
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

/// Adds an object made of `shapes` and returns its index; `object.id` is set here.
std::size_t addObject(World& world, WorldObject object, const std::vector<Shape>& shapes);
std::size_t addObject(World& world, ClassId label, bool thing, const std::vector<Shape>& shapes);

/// Adds a solid to an object (index into World::objects).
void addSolid(World& world, std::size_t object, const Shape& shape);

/// The tight axis-aligned box around a shape; infinite around a plane.
Bounds boundsOf(const Shape& shape);

/// A box standing on `base` (centre of its underside), turned about z.
Box uprightBox(const Vec3& base, const Vec3& size, double yaw);

}  // namespace hgg
