#pragma once

#include <span>
#include <utility>
#include <vector>

#include "creation/cluster.h"
#include "map/local_graph.h"

namespace hgg {

/// k-d partition of an instance's points (body frame, reordered in place): the widest axis is split at its mean until a
/// part has at most `leaf_points`. A part is split again at a gap wider than `bridge` allows at its range, so that no
/// leaf spans the empty space between two clumps of a stuff tile. Each part becomes a leaf Gaussian in the object
/// frame.
std::vector<LocalLeaf> partitionLeaves(std::span<PackedPoint> points, const Pose& T_body_object, int leaf_points,
                                       const RadiusLaw& bridge);

}  // namespace hgg
