#pragma once

#include <functional>
#include <vector>

#include "sim/world.h"

namespace hgg {

/// Points spread evenly over the surface of a shape, about `spacing` m apart, at least one a face. An unbounded plane
/// is sampled where it passes `within`. `normal` points outwards; it is zero where both sides are outside.
void sampleSurface(const Shape& shape, double spacing, const Bounds& within,
                   const std::function<void(const Vec3& p, const Vec3& normal)>& point);

/// All of the object's surfaces, inner ones too; planes give nothing.
std::vector<Vec3> sampleObject(const World& world, std::size_t object, double spacing);

}  // namespace hgg
