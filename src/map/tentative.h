#pragma once

#include <vector>

#include "config.h"
#include "core/class_belief.h"
#include "core/classes.h"
#include "map/local_graph.h"
#include "map/map.h"
#include "map/range_image.h"
#include "map/tentative_things.h"

namespace hgg {

/// A tentative thing that has gathered enough to be a thing.
struct GrownThing {
  LocalObject object;  // body frame, all points that were gathered
  ClassWeights views;  // that found it, and that did not (as class 0: whatever they saw)
  std::int32_t frames = 0;
  Micros first_us = 0;
};

/// What has become of tentative things by a frame.
struct SmallThings {
  std::vector<GrownThing> grown;
  TentativeThings tentative;  // the others
};

/// Where the beams of a frame ended, as the test for small things asks it.
struct FrameBeams {
  const RangeImage& image;
  const Pose& T_map_sensor;
  double per_counted = 1;  // beams of the frame for each one in the image
};

/// Gathers evidence below min_points: track before detect. Small clusters in the middle of other surfaces are grains of
/// wrong labels and left out, and so are those of classes that can move. A cluster at a confirmed node of its class
/// belongs to that; else it belongs to the tentative thing that it touches, or begins one. The others that the frame
/// looked at are missed. Those that are no more often found than noise is are dropped; those that noise cannot explain
/// have grown into things. `weight`: of the frame's view (viewWeight).
SmallThings gatherSmallThings(const Map& map, const LocalGraph& local, const FrameBeams& beams, const Pose& T_map_body,
                              double weight, const ClassTable& classes, const Config& config);

/// Moves them with their anchor keyframes; `moves`: ascending.
void moveThings(TentativeThings& things, const KeyframeMoves& moves);

}  // namespace hgg
