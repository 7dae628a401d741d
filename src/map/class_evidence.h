#pragma once

#include <vector>

#include "map/local_graph.h"
#include "map/map.h"
#include "map/range_image.h"

namespace hgg {

/// What a frame sees through.
struct FreeSpace {
  RangeImage image;
  Pose T_map_sensor;               // axes of the body, origin where the image was taken
  double variance = 0;             // m^2 along each axis, of the frame's position in the map
  double variance_turn = 0;        // rad^2
  std::vector<NodeId> found = {};  // ascending: things that the frame has as objects of their own
};

/// Evidence about the class of every active thing within `radius` (m) of the robot that the frame has points at,
/// ascending by id. Each of the thing's leaves votes for the class that has most of the frame's points in the leaf's
/// footprint exp(-d^T Sigma^-1 d / 2), as expected under the frame's leaves. A frame that has other classes where a
/// thing should be is evidence against the thing. Votes are multiplied by `weight`; `sigma_floor` (m) is added to the
/// leaves' extents. With `free`, a leaf also votes for free space, by the chance that one of the beams that pass would
/// have hit it, and as far as it has no points. Leaves that are hidden, out of view or without returns do not vote.
std::vector<ClassEvidence> classEvidence(const LocalGraph& local, const Map& map, const Pose& T_map_body, double weight,
                                         double radius, double sigma_floor, const FreeSpace* free = nullptr);

/// The weight of a frame's views after the motion T_last_body since the frame before: 1 from 5 cm or one degree on.
/// Frames from one place repeat each other's mistakes, so that fifty at rest count as one: a robot that parks for a
/// night in front of a thing that its segmenter mistakes does not unlearn the thing.
double viewWeight(const Pose& T_last_body);

/// Views of the place of a new thing from before it was one: of each stuff class, how many times as many points the map
/// has in the footprints of the object's leaves as the object brings, on average over the leaves. A wall that was seen
/// fifty times, and now passes for a trunk, has been no trunk fifty times. Reads active nodes.
ClassWeights viewsAsStuff(const Map& map, const LocalObject& object, const Pose& T_map_body, double sigma_floor);

/// Share of the points of `object` (body frame) that lie on the surface of `node` (0 .. 1), that is in the footprints
/// of its leaves. A leaf of the object counts in full when as much of it lies in them as would lie in its own
/// footprint.
double shareOn(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double sigma_floor);
/// The same of another node.
double shareOn(const MapNode& node, const MapNode& other, double sigma_floor);

}  // namespace hgg
