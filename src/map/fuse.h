#pragma once

#include <span>
#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// How two beliefs become one: merge() (eq. merge), or what an evaluation holds against it.
using MergeRule = Belief (*)(const Belief&, const Belief&);

/// Ablation: half and half whatever the evidence. Mean (a + b) / 2, covariance the average plus the spread of the two
/// means; kappa adds.
Belief mergeSymmetrically(const Belief& a, const Belief& b);

/// Merges leaves given in another frame into `leaves`. A cubic grid in the frame of `leaves` holds one leaf a cell; its
/// cells are leaf_size wide, and twice that for each level of detail a leaf is coarser. A leaf joins (by `rule`) the
/// one of its cell or, where that is empty, one in a cell next door less than half a cell away. So the number of leaves
/// is bounded by the surface and the resolution it was seen with, not by how often it was seen. Evidence is kept.
void fuseLeaves(std::vector<Leaf>& leaves, std::span<const Belief> additions, const Pose& T_leaves_additions,
                double leaf_size, MergeRule rule = merge);

/// Merge of two map nodes, conjugate by default: beliefs and leaves; `keep` keeps its id and frame.
void absorb(MapNode& keep, const MapNode& other, double leaf_size, MergeRule rule = merge);

/// Map update: matched objects merge into their nodes, unmatched ones become nodes, then same-class things that are one
/// object merge (a segmenter splits an object, a grazing beam leaves a gap in it). Returns what the map has to change.
MapUpdate fuse(const Map& map, const LocalGraph& local, const Pose& T_map_body, const std::vector<ObjectPair>& pairs,
               const ClassTable& classes, const Config& config);

}  // namespace hgg
