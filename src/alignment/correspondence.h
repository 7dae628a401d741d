#pragma once

#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Coarse correspondence C^o at a given pose. Things: same class, E = a W2 + (1 - a) |H_i - H_j| below the gate,
/// optimal one-to-one assignment. Stuff: the node of the same tile. Sorted by local index.
std::vector<ObjectPair> coarseCorrespondence(const LocalGraph& local, const Map& map, const Pose& T_map_body,
                                             const Config& config);

/// Two leaves of matched objects that stand for the same surface.
struct LeafPair {
  int pair = 0;            // index into the object pairs
  int local = 0, map = 0;  // indices into the leaves of the two objects
};

/// Fine correspondence C^g at a given pose, inside matched objects only: a leaf of the frame and one of its nearest
/// leaves of the node within `alignment.leaf_gate`, by optimal one-to-one assignment of a |du|^2 + (1 - a) D_WL, a =
/// alignment.leaf_geometry_share. At most `alignment.max_leaf_pairs` leaves of the frame are looked at, spread evenly
/// over it.
std::vector<LeafPair> fineCorrespondence(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                         const Pose& T_map_body, const Config& config);

}  // namespace hgg
