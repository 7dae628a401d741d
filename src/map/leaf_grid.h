#pragma once

#include <span>

#include "map/geometry.h"

namespace hgg {

/// How two beliefs become one: merge() (eq. merge), or what an evaluation holds against it.
using MergeRule = Belief (*)(const Belief&, const Belief&);

/// `leaves` with leaves given in another frame merged into them. A cubic grid in the frame of `leaves` holds one leaf a
/// cell; its cells are leaf_size wide, and twice that for each level of detail a leaf is coarser. A leaf joins (by
/// `rule`) the one of its cell or, where that is empty, one in a cell next door less than half a cell away. So the
/// number of leaves is bounded by the surface and the resolution it was seen with, not by how often it was seen.
/// Evidence is kept.
Leaves fuseLeaves(std::span<const Leaf> leaves, std::span<const Belief> additions, const Pose& T_leaves_additions,
                  double leaf_size, MergeRule rule = merge);

}  // namespace hgg
