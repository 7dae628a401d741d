#pragma once

#include <vector>

#include "config.h"
#include "frame/frame.h"
#include "map/local_graph.h"

namespace hgg {

/// What the edges of an object graph need of a node.
struct GraphNode {
  ClassId label = 0;
  const Belief* belief = nullptr;
};

/// Relative neighbourhood graph over the means of `nodes`, with the weights of eq. rel_weights: w = c S1 / S1max + (1 -
/// c) S2, where S1 is edgeDistance, S1max its largest value in this graph, S2 is 0 between equal classes and 1
/// otherwise, and c = config.edge_geometry_share.
std::vector<LocalEdge> connectObjects(const std::vector<GraphNode>& nodes, const CreationConfig& config);

/// Creation: turns one frame into its local graph G_t, in the body frame. T_map_body is the predicted pose; it is only
/// used to lay the tiles of stuff.
LocalGraph createLocalGraph(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                            const Config& config);

}  // namespace hgg
