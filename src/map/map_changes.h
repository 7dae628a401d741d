#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "map/keyframes.h"
#include "map/node.h"
#include "map/object_graph.h"

namespace hgg {

/// The nodes anchored to one keyframe, out of the map.
struct MapPage {
  KeyframeId keyframe = -1;  // -1: those anchored to none
  Pose T_map_keyframe = Pose::Identity();
  std::vector<MapNode> nodes;  // ascending by id; where they were when their keyframe was there
};

/// What a map knows beside keyframes and nodes.
struct MapHead {
  std::map<ClassId, std::string> class_names;
  double tile_size = 0;  // m
  Micros odometry_delay_us = 0;
  std::int64_t revision = 0;
  NodeId next_id = 1;
  std::optional<EdgeModel> edges;  // of its graph, if it keeps one
};

/// How a map differs from what was written of it before.
struct MapChanges {
  MapHead head;
  std::vector<MapPage> pages;  // as they are now, all of what is anchored to these keyframes
  std::vector<std::pair<KeyframeId, TimedPose>> keyframes;
  std::size_t first_constraint = 0;
  std::vector<BetweenConstraint> constraints;  // all of them from the first on
};

}  // namespace hgg
