#pragma once

#include <vector>

#include "config.h"
#include "map/leaf_grid.h"
#include "map/local_graph.h"
#include "map/map.h"
#include "map/tentative.h"

namespace hgg {

/// Ablation: a merge that gives both beliefs the same weight whatever their evidence. The mean is (a + b) / 2, the
/// covariance the average plus the spread of the two means; kappa adds up.
Belief mergeSymmetrically(const Belief& a, const Belief& b);

/// Merges the beliefs, class beliefs and leaves of `other` into `keep`, which keeps its id and its object frame. The
/// merge of beliefs is conjugate (eq. merge) unless `rule` says otherwise.
void absorb(MapNode& keep, const MapNode& other, double leaf_size, MergeRule rule = merge);

/// Computes what a frame changes in the map. Matched objects (`pairs`) merge into their nodes. Unmatched ones become
/// new nodes, or join the thing of another class on whose surface they lie. `evidence` is added to the class beliefs; a
/// thing takes the label of its likeliest class and is removed when its existence falls below 0.1. Then things of one
/// class that are one object merge: a segmenter may have split it, or a grazing beam may have left a gap in it.
/// `small`: what the clusters tell that are too small to be objects.
MapUpdate fuse(const Map& map, const LocalGraph& local, const Pose& T_map_body, const std::vector<ObjectPair>& pairs,
               const std::vector<ClassEvidence>& evidence, const ClassTable& classes, const Config& config,
               SmallThings small = {});

/// Computes how each node of `pending` (ids, ascending) merges with the active nodes that are the same object: stuff
/// of one tile, things that are one object. These are nodes that a loop closure has moved onto others, or that were out
/// of reach and are active again. Ids of nodes that are gone or not active are skipped. The update is a sequel to the
/// frame before it.
MapUpdate mergeDuplicates(const Map& map, const std::vector<NodeId>& pending, const ClassTable& classes,
                          const Config& config);

}  // namespace hgg
