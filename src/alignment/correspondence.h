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

}  // namespace hgg
