#pragma once

#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Evidence about the class of every thing that the frame has points at, ascending by id: each of the thing's leaves
/// speaks for the class with most points in its soft window exp(-d^T Sigma^-1 d / 2), as expected under the frame's
/// leaves. A frame that has other classes where a thing should be speaks against it.
std::vector<ClassEvidence> classEvidence(const LocalGraph& local, const Map& map, const Pose& T_map_body,
                                         const Config& config);

/// Share of the points of `object` (body frame) that lie on the surface of `node`: in the windows of its leaves, a leaf
/// counting whole when it has as many there as in the window of one just like it.
double shareOn(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double sigma_floor);

}  // namespace hgg
