#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "traversability/cost_grid.h"

namespace hgg {

/// A place asked for: where the height is left out, the surface nearest to the grid's ground is meant.
struct PlanPoint {
  double x = 0, y = 0;      // m, map frame
  std::optional<double> z;  // m, map frame
};

/// How far from the place that was asked for a path may begin or end where nobody can stand on that place itself, m: as
/// much as is usual of planners (Nav2: 0.5 m).
inline constexpr double kPlanTolerance = 0.5;

struct PlanRequest {
  PlanPoint from, to;
  double ground_z = 0;         // m, map frame: the height meant where a point has none
  bool allow_unknown = false;  // walk over columns where nothing was seen, too
  double tolerance = kPlanTolerance;
};

struct Plan {
  bool found = false;
  std::vector<Vec3> path;       // map frame, on the ground; begins at `from`, ends at `to` or goal_distance from it
  double goal_distance = 0;     // m, level: more than 0 where `to` is no ground to stand on
  double length = 0;            // m
  double cost = 0;              // m, the length with what is bad about the ground added
  double worst_confidence = 0;  // 0..1, of the surfaces under the path; 0: some were filled in, never seen
  std::string reason;           // why there is none
};

/// The cheapest way for a robot of the limits' footprint: A* over the surfaces of the grid. A metre of well-known flat
/// ground costs a metre; bad or hardly known ground up to kWorstFactor times as much (foothold.cpp). The robot's
/// centre keeps the footprint radius from everything it cannot walk on.
Plan planPath(const CostGrid& grid, const TraversabilityConfig& limits, const PlanRequest& request);

/// A surface of a grid, by its index, that a way may end at, and what it costs to end there instead of elsewhere, m.
struct PlanEnd {
  std::uint32_t surface = 0;
  double penalty = 0;  // at least 0
};

struct PlanToAny {
  Plan plan;
  std::size_t end = 0;  // which one it leads to
};

/// The way to whichever end is cheapest, penalty and all, in one search. Ends where the robot's footprint has no room
/// count for nothing. `ground_z` as in PlanRequest.
PlanToAny planToAny(const CostGrid& grid, const TraversabilityConfig& limits, const PlanPoint& from, double ground_z,
                    std::span<const PlanEnd> ends);

}  // namespace hgg
