#pragma once

#include <memory>
#include <span>
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

/// Finds the surfaces near a point, by nanoflann's k-d tree over their means. Surfaces whose mean is not finite, or
/// absurdly far away, are never found.
class SurfaceIndex {
 public:
  explicit SurfaceIndex(std::span<const Surface> surfaces);
  ~SurfaceIndex();

  /// Fills `found` with the indices of the surfaces whose mean lies within `radius` (m) of p. Their order is that of
  /// the tree: any, but always the same for the same surfaces.
  void near(const Vec3& p, double radius, std::vector<std::size_t>& found) const;

 private:
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace hgg
