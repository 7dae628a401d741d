#pragma once

#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Coarse correspondence C^o of the frame's objects with active nodes, at a given pose. Things pair with things of the
/// same class whose cost E = a W2 + (1 - a) |H_i - H_j| (eq. cost, m) is below `alignment.gate`, one-to-one and with
/// the least sum of costs; a is `alignment.geometry_share`. Stuff pairs with the node of its tile. Sorted by local
/// index.
std::vector<ObjectPair> coarseCorrespondence(const LocalGraph& local, const Map& map, const Pose& T_map_body,
                                             const Config& config);

/// Two leaves of matched objects that lie on the same surface.
struct LeafPair {
  int pair = 0;            // index into the object pairs
  int local = 0, map = 0;  // indices into the leaves of the two objects
};

/// Fine correspondence looks at every so many leaves of the frame, so that at most `at_most` of those in matched
/// objects take part, spread evenly over it.
std::size_t leafStride(const LocalGraph& local, const std::vector<ObjectPair>& pairs, int at_most);

/// Fine correspondence C^g at a given pose, inside matched objects only. A leaf of the frame pairs with one of the
/// nearest leaves of its object's node within `leaf_gate`, one-to-one and with the least sum of a |du|^2 + (1 - a)
/// D_WL; a is `leaf_geometry_share`. At most `max_leaf_pairs` leaves of the frame are looked at, spread evenly over it.
/// `sigma_floor` (m) is added to the leaves' extents before their logarithm is taken.
std::vector<LeafPair> fineCorrespondence(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                         const Pose& T_map_body, const AlignmentConfig& config, double sigma_floor);

}  // namespace hgg
