#pragma once

#include <span>

#include "map/geometry.h"

namespace hgg {

/// How two beliefs are merged: merge() (eq. merge), or another rule that an evaluation compares it with.
using MergeRule = Belief (*)(const Belief&, const Belief&);

/// `leaves` with `additions`, leaves given in another frame, merged into them. A cubic grid in the frame of `leaves`
/// holds one leaf in each cell. Cells are leaf_size (m) wide, and twice as wide for each level of detail that a leaf is
/// coarser. A leaf is merged (by `rule`) with the leaf of its cell or, where the cell is empty, with one in a cell next
/// to it that is less than half a cell away. So the number of leaves is bounded by the surface and the resolution that
/// it was seen with, not by how often it was seen. The sum of the evidence does not change.
Leaves fuseLeaves(std::span<const Leaf> leaves, std::span<const Belief> additions, const Pose& T_leaves_additions,
                  double leaf_size, MergeRule rule = merge);

}  // namespace hgg
