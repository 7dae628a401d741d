#pragma once

#include <algorithm>
#include <cmath>

#include "core/belief.h"

namespace hgg {

// A Gaussian as an evenly filled patch: what tells whether two are parts of one surface.

/// An evenly filled patch ends sqrt(3) standard deviations from its middle.
inline constexpr double kPatchSigmas = 1.732;
/// How far apart pieces of one object can be, in cluster radii: something that hides the surface between them also cuts
/// clusters. Chosen by hand; docs/experiments.md, "One object, two nodes", says what the rule gains.
inline constexpr double kFragmentDistance = 2;

/// Gap between two patches along the line of their means, m; negative where they overlap.
inline double surfaceGap(const Belief& a, const Belief& b) {
  const Vec3 d = b.mean - a.mean;
  const double length = d.norm();
  if (length == 0) {
    return 0;
  }
  const Vec3 u = d / length;
  return length -
         kPatchSigmas * (std::sqrt(std::max(u.dot(a.cov * u), 0.0)) + std::sqrt(std::max(u.dot(b.cov * u), 0.0)));
}

}  // namespace hgg
