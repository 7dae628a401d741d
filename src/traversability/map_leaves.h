#pragma once

#include <map>
#include <vector>

#include "map/map.h"

namespace hgg {

/// What grids and voxels are made from: the nodes, whose leaves must be in memory, and the keyframes they were seen
/// from. Of a map, or of a copy of what is in it (traversability/leaf_copy.h). Owns nothing.
struct MapLeaves {
  const std::map<NodeId, MapNode>& nodes;
  const std::vector<TimedPose>& keyframes;

  MapLeaves(const std::map<NodeId, MapNode>& nodes_of, const std::vector<TimedPose>& keyframes_of)
      : nodes(nodes_of), keyframes(keyframes_of) {}
  MapLeaves(const Map& map) : MapLeaves(map.nodes(), map.keyframes().poses()) {}  // NOLINT(google-explicit-constructor)
};

}  // namespace hgg
