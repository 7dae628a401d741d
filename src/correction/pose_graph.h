#pragma once

#include <span>
#include <vector>

#include "core/se3.h"
#include "map/between_constraint.h"

namespace hgg {

struct PoseGraphSolution {
  std::vector<Pose> poses;                 // T_map_body
  double cost_before = 0, cost_after = 0;  // half the robust sum of squares
  int iterations = 0;
  bool converged = false;
  std::vector<double> loop_weights;  // 0 .. 1, of each loop in the constraints' order: how far it was believed
};

/// Spreads the loops' corrections over the keyframes. `poses` (T_map_body) are the start; the first one stays fixed.
/// Loops carry a robust loss, so a false one loses its weight instead of bending the map. Poses that no constraint
/// connects to the first stay as they are. Every constraint must name two different poses and have positive standard
/// deviations. Single-threaded: the same input gives the same bytes.
PoseGraphSolution solvePoseGraph(const std::vector<Pose>& poses, std::span<const BetweenConstraint> constraints);

}  // namespace hgg
