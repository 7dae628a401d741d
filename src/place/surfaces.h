#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "core/types.h"

namespace hgg {

/// A leaf Gaussian as a piece of surface.
struct Surface {
  Vec3 mean = Vec3::Zero();
  Mat3 cov = Mat3::Zero();      // what it is matched under, m^2: thin across the surface, loose along it
  Vec3 normal = Vec3::UnitZ();  // axis of the least extent
  bool is_level = false;        // flat and facing up: the same wherever along the ground it lies
  ClassId label = 0;
};

/// Finds surfaces near a point: a grid of cubic cells, one radius wide. None where the radius is not above 0.
class SurfaceIndex {
 public:
  SurfaceIndex(std::span<const Surface> surfaces, double radius);

  /// Indices of the surfaces whose mean lies within the radius, in a fixed order.
  void near(const Vec3& p, std::vector<std::size_t>& found) const;

 private:
  std::uint64_t keyOf(const Vec3& p, int dx, int dy, int dz) const;

  struct Entry {
    Vec3 mean;  // beside the index, so that a search stays in the cell
    std::size_t index;
  };
  double radius_;
  std::unordered_map<std::uint64_t, std::vector<Entry>> cells_;
};

}  // namespace hgg
