#pragma once

#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Evidence about the class of every thing that the frame has points at, ascending by id: each of the thing's leaves
/// speaks for the class with most points in its soft window exp(-d^T Sigma^-1 d / 2), as expected under the frame's
/// leaves. A frame that has other classes where a thing should be speaks against it.
/// All of it is times `weight`.
std::vector<ClassEvidence> classEvidence(const LocalGraph& local, const Map& map, const Pose& T_map_body, double weight,
                                         const Config& config);

/// What a frame counts after a motion since the last one: 1 from 5 cm or one degree on. Frames from one place repeat
/// each other's mistakes: fifty at rest count as one, so that what is seen wrong from where a robot parks for the night
/// is still there in the morning.
double viewWeight(const Pose& T_last_body);

/// Share of the points of `object` (body frame) that lie on the surface of `node`: in the windows of its leaves, a leaf
/// counting whole when it has as many there as in the window of one just like it.
double shareOn(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double sigma_floor);

}  // namespace hgg
