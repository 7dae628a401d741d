#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "place/candidates.h"

namespace hgg {

/// What a map without surfaces is taken to have surveyed: the convex hull of the middles of its things, seen from
/// above.
struct Outline {
  std::vector<Eigen::Vector2d> corners;  // anticlockwise, no three in a line; m, map frame
  double room = 0;                       // m^2: its area with a margin all around, which things at the edge stand in
};

Outline outlineOf(std::span<const Landmark> landmarks);

/// Whether a place lies inside, and not within a margin of the edge, where it is chance on which side a thing is.
bool isSurveyed(const Outline& outline, const Vec3& p);

}  // namespace hgg
