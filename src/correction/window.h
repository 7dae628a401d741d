#pragma once

#include <vector>

#include "core/belief.h"
#include "core/se3.h"
#include "correction/observation.h"

namespace hgg {

/// A measured motion between two poses of the window (eq. odom_res). The information's tangent is (translation,
/// rotation vector) in frame a about b's origin.
struct RelativeMotion {
  int a = 0, b = 0;
  Pose T_a_b = Pose::Identity();
  Mat6 information = Mat6::Identity();
};

/// What the frame of a pose saw of an object: its own points only, not what has accumulated.
struct WindowObservation {
  int pose = 0, object = 0;
  Belief belief_body;
};

/// eq. fgo: the poses of a sliding window, oldest first, and the objects seen from them. Motions and observations that
/// say nothing (kappa 0, not finite, no such pose or object) are left out.
struct WindowProblem {
  std::vector<Pose> poses;  // T_map_body, from alignment
  PoseBelief oldest;        // prior of poses[0]
  std::vector<RelativeMotion> motions;
  std::vector<Belief> objects;  // map frame, gathered before the window; kappa 0: nothing is known
  std::vector<WindowObservation> observations;
};

struct WindowConfig {
  ObservationNoise noise;
  double sigma_floor = 0.01;  // m, of every extent
  /// On an object factor's whitened norm: 99 % of true ones (chi-square, 9 degrees of freedom) lie below and count in
  /// full; the pull of the rest falls off (ScalingLoss).
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
