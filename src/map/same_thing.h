#pragma once

#include <vector>

#include "config.h"
#include "core/classes.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// What says whether two things of one class are one.
struct SameThing {
  double cluster_radius = 0;  // m, of the class
  double sigma_floor = 0;     // m
  double merge_overlap = 0, fragment_share = 0;
};

/// Of a class of the table, or of one that it does not know (nullptr).
SameThing sameThing(const ClassInfo* info, const Config& config);

/// One object seen as two: the extents overlap, the smaller one's middle lies inside the larger one, or one is a piece,
/// with little evidence, that touches the other.
bool areOneObject(const MapNode& a, const MapNode& b, const SameThing& rule);

/// True when the object of a frame (body frame) can be a view of the node of its class: one's middle lies inside the
/// other, or surfaces come closer than `reach` (m).
bool canBeViewOf(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double reach,
                 double sigma_floor);

/// Takes out the pairs of things whose object is no view of its node: as far apart as neither fragments nor the beams
/// leave surfaces. Within its gate, alignment pairs an object with a neighbour where the thing itself is not known, but
/// the two must not become one.
void keepViews(std::vector<ObjectPair>& pairs, const Map& map, const LocalGraph& local, const Pose& T_map_body,
               const ClassTable& classes, const Config& config);

}  // namespace hgg
