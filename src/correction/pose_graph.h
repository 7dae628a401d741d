#pragma once

#include <span>
#include <vector>

#include "core/se3.h"

namespace hgg {

/// A measured motion between two keyframes, from the chain of odometry and alignment or from a loop closure. The
/// information's tangent is (translation, rotation vector) in frame a about b's origin (eq. odom_res).
struct PoseGraphEdge {
  int a = 0, b = 0;
  Pose T_a_b = Pose::Identity();
  Mat6 information = Mat6::Identity();
  bool loop = false;
};

struct PoseGraphSolution {
  std::vector<Pose> poses;                 // T_map_body
  double cost_before = 0, cost_after = 0;  // half the robust sum of squares
  int iterations = 0;
  bool converged = false;
  std::vector<double> loop_weights;  // 0 .. 1, one per loop edge in the edges' order: how far it was believed
};

/// Spreads the loops' corrections over the keyframes, `poses` (T_map_body) being their start and the first staying
/// fixed. Loops carry a robust loss, so a false one loses its weight instead of bending the map. Poses that no edge
/// connects to the first stay as they are. Edges between valid, different poses only. Single-threaded: same input, same
/// bytes.
PoseGraphSolution solvePoseGraph(const std::vector<Pose>& poses, std::span<const PoseGraphEdge> edges);

}  // namespace hgg
