#pragma once

#include <string>
#include <vector>

#include "alignment/correspondence.h"

namespace hgg {

/// What alignment found, with its evidence.
struct Alignment {
  Pose T_map_body = Pose::Identity();
  std::vector<ObjectPair> pairs;
  std::string reason;  // how the pose came about
};

/// Alignment of a frame's graph with the map. The pose is the prediction itself (odometry); the correspondences are
/// made at it.
Alignment align(const LocalGraph& local, const Map& map, const Pose& T_map_body_predicted, const Config& config);

}  // namespace hgg
