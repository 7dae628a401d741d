#pragma once

#include <string>
#include <vector>

#include "config.h"
#include "map/map.h"
#include "traversability/cost_grid.h"
#include "traversability/planner.h"

namespace hgg {

/// Farthest that a goal may be from the surface of its thing, m.
inline constexpr double kGoalReach = 1.0;

/// Where to go for a thing.
struct Goal {
  bool found = false;
  Vec3 position = Vec3::Zero();  // m, map frame, on the ground
  double yaw = 0;                // rad, towards the thing
  double distance = 0;           // m, along the ground to the nearest surface of the thing
  std::vector<Vec3> path;        // from where one is; m, map frame
  std::string reason;            // why there is none, or why it is farther away than kGoalReach
};

/// A pose in traversable space within kGoalReach of the surface of a node, facing it, that can be reached from `from`:
/// on good ground, and near who goes. Where nothing so near can be reached, the nearest pose that can, with the reason.
/// `ground_z`: the height meant where `from` has none.
Goal findGoal(const Map& map, NodeId target, const CostGrid& grid, const TraversabilityConfig& limits,
              const PlanPoint& from, double ground_z);

}  // namespace hgg
