#pragma once

#include <span>
#include <vector>

#include "config.h"
#include "creation/cluster.h"
#include "frame/frame.h"
#include "map/node.h"

namespace hgg {

/// Points of one object of a frame; `points` is a range of Instances::points.
struct Instance {
  ClassId label = 0;
  std::uint32_t instance = 0;
  bool stuff = false;
  Tile tile;
  std::size_t begin = 0, end = 0;
};

/// A frame cut into instances: things by Euclidean clustering inside each (class, segmenter instance), stuff by
/// map-frame tiles. Points of dropped clusters stay in `points` without an instance.
struct Instances {
  std::vector<PackedPoint> points;
  std::vector<Instance> list;
  std::size_t nonfinite_points = 0, out_of_range_points = 0, ignored_points = 0, unknown_labels = 0;
};

/// r(d) with the beam spacing of the config and the given smallest radius (m).
RadiusLaw radiusLaw(const CreationConfig& config, double radius_min);

Instances segmentInstances(const Frame& frame, const Pose& T_map_body, const ClassTable& classes, const Config& config);

}  // namespace hgg
