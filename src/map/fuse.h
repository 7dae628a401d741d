#pragma once

#include <vector>

#include "config.h"
#include "map/leaf_grid.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Ablation: half and half whatever the evidence. Mean (a + b) / 2, covariance the average plus the spread of the two
/// means; kappa adds.
Belief mergeSymmetrically(const Belief& a, const Belief& b);

/// Merge of two map nodes, conjugate by default: beliefs and leaves; `keep` keeps its id and frame.
void absorb(MapNode& keep, const MapNode& other, double leaf_size, MergeRule rule = merge);

/// Map update: matched objects merge into their nodes, unmatched ones become nodes, or join the thing of another class
/// on whose surface they lie. The evidence goes into the class beliefs; things get the label of their likeliest class,
/// and go when their existence has faded. Then same-class things that are one object merge (a segmenter splits an
/// object, a grazing beam leaves a gap in it). Returns what the map has to change.
MapUpdate fuse(const Map& map, const LocalGraph& local, const Pose& T_map_body, const std::vector<ObjectPair>& pairs,
               const std::vector<ClassEvidence>& evidence, const ClassTable& classes, const Config& config);

/// Merges each of `overlaid` (ids, ascending; what is gone or not active is passed over) with the active nodes it is
/// one with: stuff of one tile, things that are one object. What a loop has brought together, or what was out of reach
/// for a while. A sequel to the frame before it.
MapUpdate mergeDuplicates(const Map& map, const std::vector<NodeId>& overlaid, const ClassTable& classes,
                          const Config& config);

}  // namespace hgg
