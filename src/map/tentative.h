#pragma once

#include <utility>
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

/// What the clusters of a frame that are too small to be objects tell.
struct SmallThings {
  std::vector<LocalObject> clusters;                        // those that are no grains within another surface
  std::vector<std::pair<std::size_t, NodeId>> known;        // of these, pieces of things that are in the map
  std::vector<GrownThing> grown;                            // by the frames so far
  TentativeThings tentative;                                // the others, as they are after this frame
};

/// Where the beams of a frame ended, as the test for small things asks it.
struct FrameBeams {
  const RangeImage& image;
  const Pose& T_map_sensor;
  double per_counted = 1;  // beams of the frame for each one in the image
};

/// Gathers evidence below min_points: track before detect. Small clusters in the middle of other surfaces are grains of
/// wrong labels and left out. A cluster that touches an active node of its class belongs to it; else it belongs to the
/// tentative thing that it touches, or begins one. The others that the frame looked at are missed. Those that are no
/// more often found than noise is are dropped; those that noise cannot explain have grown into things. `weight`: of the
/// frame's view (viewWeight), `pairs`: what alignment has paired.
SmallThings gatherSmallThings(const Map& map, const LocalGraph& local, const FrameBeams& beams, const Pose& T_map_body,
                              double weight, const std::vector<ObjectPair>& pairs, const ClassTable& classes,
                              const Config& config);

}  // namespace hgg
