#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/types.h"

namespace hgg {

/// Largest gap inside a cluster as a function of range d (m): r(d) = max(radius_min, slope * d), because the beams of a
/// spinning LiDAR spread with range. slope is the beam factor times the vertical beam spacing (rad), below 0.15.
struct RadiusLaw {
  float radius_min = 0.5F;
  float slope = 0;
  float at(float range) const { return std::max(radius_min, slope * range); }
};

/// True when the points are closer to each other than r at the range of the nearer one.
inline bool areNeighbours(const PackedPoint& p, const PackedPoint& q, const RadiusLaw& law) {
  const PackedPoint d = p - q;
  const float square = (d * d).sum();
  return square < law.radius_min * law.radius_min ||
         square < law.slope * law.slope * std::min((p * p).sum(), (q * q).sum());
}

/// Euclidean clustering: the connected components of areNeighbours, exactly. Returns the component of each point,
/// numbered by first appearance. Time is linear in the number of points as long as their density is bounded. Points
/// must be finite and within 2^20 cells (radius_min / sqrt(3)) of the origin.
std::vector<std::int32_t> clusterEuclidean(std::span<const PackedPoint> points, const RadiusLaw& law);

}  // namespace hgg
