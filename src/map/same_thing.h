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
  bool has_parts = true;      // its parts may be seen apart; not of what moves by itself, which parks side by side
  double sigma_floor = 0;     // m
  double merge_overlap = 0, fragment_share = 0;
  double gate = 0;            // m, of alignment
  bool loose_pieces = false;  // Config::ablation
};

/// Of a class of the table, or of one that it does not know (nullptr).
SameThing sameThing(const ClassInfo* info, const Config& config);

/// One object seen as two: the means are within the gate, and the extents overlap, the smaller one's middle lies inside
/// the larger one, or one is a piece with little evidence that touches the other. Or, wherever the means are, most of
/// the smaller one's surface is where clustering would join it with the other: a basin on its foot, the head of a bed.
bool areOneObject(const MapNode& a, const MapNode& b, const SameThing& rule);

/// m from the node's middle, within which the middle of anything lies that could be one with it.
double reachOf(const MapNode& node, const SameThing& rule);

/// True when `weak` is no thing of its own but `strong` under another name: more than half of it lies on the surface of
/// that one, which is confirmed and was called what it is more often. Two things cannot be at one place.
bool isOtherName(const MapNode& strong, const MapNode& weak, double sigma_floor);

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
