#pragma once

#include <span>
#include <vector>

#include "config.h"
#include "creation/cluster.h"
#include "frame/frame.h"
#include "map/node.h"

namespace hgg {

/// The points of one object of a frame.
struct Instance {
  ClassId label = 0;
  std::uint32_t instance = 0;  // the segmenter's, 0 = none
  bool stuff = false;
  Tile tile;                       // stuff only
  std::size_t begin = 0, end = 0;  // its points in Instances::points
};

/// A frame cut into instances. Things are clusters (clusterEuclidean) of the points with one class and one instance id
/// of the segmenter; stuff is cut by the tiles of the map frame. Points of tiles with too few points stay in `points`
/// without an instance.
struct Instances {
  std::vector<PackedPoint> points;
  std::vector<Instance> list;
  std::vector<Instance> small;  // clusters with fewer points than an object of the class needs
  std::size_t nonfinite_points = 0, out_of_range_points = 0, ignored_points = 0, unknown_labels = 0;
};

/// r(d) with the beam spacing of the config and the given smallest radius (m).
RadiusLaw radiusLaw(const CreationConfig& config, double radius_min);

/// Cuts a frame into instances. T_map_body, the predicted pose, only lays the tiles of stuff. Points that are not
/// finite, out of range, of an ignored class or of an unknown label are left out and counted.
Instances segmentInstances(const Frame& frame, const Pose& T_map_body, const ClassTable& classes, const Config& config);

}  // namespace hgg
