#pragma once

#include <vector>

#include "config.h"
#include "frame/frame.h"
#include "map/local_graph.h"

namespace hgg {

/// A node as its edges see it.
struct GraphNode {
  ClassId label = 0;
  const Belief* belief = nullptr;
};

/// Relative neighbourhood graph over the means of `nodes` with the weights of eq. rel_weights:
/// w = c S1 / S1max + (1 - c) S2, S1max over the edges of this graph, c = config.edge_geometry_share.
std::vector<LocalEdge> connectObjects(const std::vector<GraphNode>& nodes, const CreationConfig& config);

/// Creation: one frame -> local graph G_t in the body frame. T_map_body is the predicted pose; it only lays the stuff
/// tiles.
LocalGraph createLocalGraph(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                            const Config& config);

}  // namespace hgg
