#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config.h"
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
  double path_length = 0;        // m
  double path_confidence = 0;    // 0..1, of the worst-known ground on the path
  std::string reason;            // why there is none, or why it is farther away than kGoalReach

  bool isAtThing() const { return found && reason.empty(); }
};

/// Where the way to a goal begins. With neither height the ground that the robot walked on is meant.
struct GoalStart {
  double x = 0, y = 0;             // m, map frame
  std::optional<double> ground_z;  // m, map frame
  std::optional<double> body_z;    // m, map frame, of a robot that stands there: the ground below it is meant
};

/// A pose in traversable space within kGoalReach of the surface of a node, facing it, that can be reached from `from`:
/// on good ground, and near who goes. Where nothing so near can be reached, the nearest pose that can, with the reason.
Goal findGoal(const MapLeaves& map, NodeId target, const CostGrid& grid, const TraversabilityConfig& limits,
              const GoalStart& from);

/// The same on ground that is laid for it: that around start and thing first, more where the thing is not reached there
/// or by a detour only, and in the end that of all the map, if it has at most `most_cells`.
Goal findGoalInMap(const MapLeaves& map, NodeId target, const TraversabilityConfig& limits, const GoalStart& from,
                   double most_cells);

}  // namespace hgg
