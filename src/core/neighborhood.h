#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/types.h"

namespace hgg {

/// Relative neighbourhood graph, exact: the pairs (i < j), ascending, for which no third point k is closer to both of
/// them than they are to each other, max(d(i,k), d(j,k)) < d(i,j). Nearest neighbours prune the search over a k-d tree,
/// so that it takes about n log n on scenes and is quadratic only for adversarial point sets.
std::vector<std::pair<int, int>> relativeNeighborhood(std::span<const Vec3> points);

}  // namespace hgg
