#pragma once

#include <map>
#include <span>
#include <vector>

#include "traversability/map_leaves.h"

namespace hgg {

/// What has changed of a map's leaves since a copy was brought up to date.
struct LeafChanges {
  std::vector<MapNode> nodes;        // as they are now
  std::vector<NodeId> removed;       // no longer there, or not in memory
  std::vector<TimedPose> keyframes;  // all of them
};

/// How the nodes `touched` are now. Costs what these nodes cost: blocks of leaves are shared.
LeafChanges changesOf(const Map& map, std::span<const NodeId> touched);
/// All of the map.
LeafChanges allOf(const Map& map);

/// The leaves of a map as they were at some frame, for a thread of its own to work on while the map goes on.
class LeafCopy {
 public:
  void apply(LeafChanges changes);
  MapLeaves leaves() const { return {nodes_, keyframes_}; }

 private:
  std::map<NodeId, MapNode> nodes_;
  std::vector<TimedPose> keyframes_;
};

}  // namespace hgg
