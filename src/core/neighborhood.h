#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/types.h"

namespace hgg {

/// Relative neighbourhood graph: pairs (i < j), ascending, such that no k has max(d(i,k), d(j,k)) < d(i,j). Exact.
/// Pruned by nearest neighbours over a k-d tree: about n log n on scenes, quadratic only for adversarial point sets.
std::vector<std::pair<int, int>> relativeNeighborhood(std::span<const Vec3> points);

/// The neighbours in that graph of each point of `of` (indices), ascending. Costs what those points cost, and a tree.
std::vector<std::vector<int>> relativeNeighborsOf(std::span<const Vec3> points, std::span<const int> of);

}  // namespace hgg
