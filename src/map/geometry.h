#pragma once

#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/belief.h"

namespace hgg {

/// A finer Gaussian of a geometry graph, packed (40 B), in the object frame. cov holds entries 00,11,22,01,02,12.
struct Leaf {
  std::array<float, 3> mean{};
  std::array<float, 6> cov{};
  float kappa = 0;
};

Leaf packLeaf(const Belief& belief_object);
Belief unpackLeaf(const Leaf& leaf);

using Leaves = std::vector<Leaf>;

/// Edges of a geometry graph: the relative neighbourhood graph over the means of its leaves, pairs (i < j), ascending.
/// They are found on demand. The mapper as shipped reads none (only Weisfeiler-Lehman features do, see
/// alignment.leaf_geometry_share), and finding those of every frame took 8 % of its instructions.
std::vector<std::pair<int, int>> geometryEdges(std::span<const Belief> leaves);

/// The geometry of a node: leaves in the object frame, shared and never changed once made. A node whose leaves change
/// gets a new block, so that copies of a node, snapshots of a map and other threads can share one. Corrections move
/// object frames and leave blocks alone. Null stands for geometry that is not in memory (map/paging.h).
using GeometryBlock = std::shared_ptr<const Leaves>;

GeometryBlock shareLeaves(Leaves leaves);
/// The one block without leaves.
const GeometryBlock& noLeaves();

}  // namespace hgg
