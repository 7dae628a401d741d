#pragma once

#include <vector>

#include "core/se3.h"
#include "core/units.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// Two poses, or two transforms between maps, that differ by more than this are of two places. Chosen by hand;
/// docs/experiments.md, "Why the verdict has these limits", measures rivals by it.
inline constexpr double kDistinctDistance = 1.0;      // m
inline constexpr double kDistinctTurn = 5 * kDegree;  // rad

/// How far from a pose to search: m in each horizontal direction, and rad of yaw to either side.
struct SearchReach {
  double distance = 0;
  double turn = 0;
};

/// Poses around `T_map_body` at which the upright leaves of the frame lie where the active map has leaves of the same
/// class and height, the best first, at most `count` and all distinct (areDistinctPoses). Correlative scan matching
/// (Olson 2009): every yaw, x and y within the reach is tried on a grid of the map's leaves, so that no start is
/// needed; height, roll and pitch are those of `T_map_body`. Only as exact as its grid of 1.5 `leaf_size` (m): to be
/// aligned afterwards. `radius` (m): how far around the robot the map is looked at.
std::vector<Pose> searchPoses(const LocalGraph& local, const Map& map, const Pose& T_map_body, const SearchReach& reach,
                              double radius, double leaf_size, std::size_t count);

/// Whether two poses are too far apart to be one that was found twice.
bool areDistinctPoses(const Pose& a, const Pose& b);

}  // namespace hgg
