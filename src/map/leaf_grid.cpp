#include "map/leaf_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace hgg {
namespace {

/// Cell of the leaf grid: level of detail, then the cell's index at that level.
using CellIndex = std::array<std::int32_t, 4>;

/// Leaves up to this many cells wide live in the cells of a level. What fills a cell evenly is one cell wide, and 1.41
/// once its pieces have their middles all over the cell.
constexpr float kCellsWide = 1.5F;
constexpr std::int32_t kLevels = 16;

float cellSize(std::int32_t level, float leaf_size) { return std::ldexp(leaf_size, level); }

CellIndex cellOf(const Leaf& leaf, float leaf_size) {
  // A square patch of side s has the trace s^2 / 6.
  const float width = std::sqrt(6 * (leaf.cov[0] + leaf.cov[1] + leaf.cov[2]));
  std::int32_t level = 0;
  while (level + 1 < kLevels && width > kCellsWide * cellSize(level, leaf_size)) {
    ++level;
  }
  const auto index = [&](std::size_t k) {
    return static_cast<std::int32_t>(std::floor(leaf.mean[k] / cellSize(level, leaf_size)));
  };
  return {level, index(0), index(1), index(2)};
}

struct KeyedLeaf {
  CellIndex cell;
  Leaf leaf;
};

using LeafGrid = std::vector<KeyedLeaf>;  // ascending by cell, one leaf a cell

LeafGrid::iterator lowerBound(LeafGrid& grid, const CellIndex& cell) {
  return std::lower_bound(grid.begin(), grid.end(), cell,
                          [](const KeyedLeaf& k, const CellIndex& c) { return k.cell < c; });
}

/// The leaf nearest to `leaf` in the up to seven cells that come within half a cell of it; nullptr when none is that
/// near.
Leaf* findNextDoor(LeafGrid& grid, const CellIndex& home, const Leaf& leaf, float leaf_size) {
  const float cell = cellSize(home[0], leaf_size);
  Leaf* best = nullptr;
  float best_square = 0.25F * cell * cell;
  for (unsigned mask = 1; mask < 8; ++mask) {
    CellIndex neighbour = home;
    for (unsigned k = 0; k < 3; ++k) {
      const bool upper_half = leaf.mean[k] / cell - static_cast<float>(home[k + 1]) >= 0.5F;
      neighbour[k + 1] += (mask >> k & 1U) == 0 ? 0 : upper_half ? 1 : -1;
    }
    const auto it = lowerBound(grid, neighbour);
    if (it == grid.end() || it->cell != neighbour) {
      continue;
    }
    float square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      square += (it->leaf.mean[k] - leaf.mean[k]) * (it->leaf.mean[k] - leaf.mean[k]);
    }
    if (square < best_square) {
      best_square = square;
      best = &it->leaf;
    }
  }
  return best;
}

void addToGrid(LeafGrid& grid, const Leaf& leaf, float leaf_size, MergeRule rule) {
  const CellIndex home = cellOf(leaf, leaf_size);
  const auto at = lowerBound(grid, home);
  Leaf* host = at != grid.end() && at->cell == home ? &at->leaf : findNextDoor(grid, home, leaf, leaf_size);
  if (host != nullptr) {
    *host = packLeaf(rule(unpackLeaf(*host), unpackLeaf(leaf)));
  } else {
    grid.insert(at, {home, leaf});
  }
}

/// Leaves by the cells they lie in now; merging may have moved some since they were ordered last.
LeafGrid gridOf(std::span<const Leaf> leaves, float leaf_size, MergeRule rule) {
  LeafGrid grid;
  grid.reserve(leaves.size() + 16);
  for (const Leaf& leaf : leaves) {
    const CellIndex cell = cellOf(leaf, leaf_size);
    if (grid.empty() || grid.back().cell < cell) {
      grid.push_back({cell, leaf});
    } else {
      addToGrid(grid, leaf, leaf_size, rule);
    }
  }
  return grid;
}

}  // namespace

Leaves fuseLeaves(std::span<const Leaf> leaves, std::span<const Belief> additions, const Pose& T_leaves_additions,
                  double leaf_size, MergeRule rule) {
  const auto size = static_cast<float>(leaf_size);
  LeafGrid grid = gridOf(leaves, size, rule);
  for (const Belief& addition : additions) {
    addToGrid(grid, packLeaf(transform(T_leaves_additions, addition)), size, rule);
  }
  Leaves fused;
  fused.reserve(grid.size());
  for (const KeyedLeaf& k : grid) {
    fused.push_back(k.leaf);
  }
  return fused;
}

}  // namespace hgg
