#pragma once

#include <vector>

#include "core/belief.h"
#include "core/se3.h"
#include "correction/observation.h"
#include "map/between_constraint.h"

namespace hgg {

/// What the frame of one pose saw of an object: the belief from the points of that frame alone.
struct WindowObservation {
  int pose = 0, object = 0;
  Belief belief_body;
};

/// eq. fgo: the poses of a sliding window, oldest first, and the objects seen from them. Constraints and observations
/// that say nothing (kappa 0, not finite, no such pose or object) are left out.
struct WindowProblem {
  std::vector<Pose> poses;                     // T_map_body, from alignment
  PoseBelief oldest;                           // prior of poses[0]
  std::vector<BetweenConstraint> constraints;  // a and b are indices into poses
  std::vector<Belief> objects;                 // map frame, gathered before the window; kappa 0: nothing is known
  std::vector<WindowObservation> observations;
};

struct WindowConfig {
  ObservationNoise noise;
  double sigma_floor = 0.01;  // m, of every extent
  /// Bound on an object factor's whitened norm: 99 % of true observations (chi-square, 9 degrees of freedom) lie below
  /// and count in full; the pull of the others falls off (ScalingLoss).
  double robust_scale = 4.65;
  int max_iterations = 12;
  bool position_covariances = false;
};

struct WindowSolution {
  std::vector<Pose> poses;
  std::vector<Belief> objects;  // map frame; kappa: prior and observed. One without observations stays as it was.
  Mat6 last_pose_information = Mat6::Zero();  // marginal, in the pose's tangent (core/se3.h)
  std::vector<Mat3> position_cov;             // m^2, one per object if asked for; zero for one without observations
  double cost_before = 0, cost_after = 0;     // half the robust sum of squares
  int iterations = 0;
  bool usable = false;  // if not, poses and objects are the problem's own
};

/// Minimises eq. fgo plus the priors of the oldest pose and of the objects. Pure and single-threaded: same input, same
/// bytes. Not usable without poses, with poses that are not finite, or where the last pose is left undetermined.
WindowSolution solveWindow(const WindowProblem& problem, const WindowConfig& config);

}  // namespace hgg
