#pragma once

#include <numbers>

#include "core/se3.h"
#include "map/node.h"

namespace hgg {

/// How pose b was measured to lie from pose a (a between factor, eq. odom_res): by alignment from one keyframe to the
/// next, by the part of the map that b was aligned with while that part is anchored to a, or by a verified loop. In the
/// keyframe graph and the pose graph a and b are keyframes; in a window's problem they are indices into its poses.
struct BetweenConstraint {
  KeyframeId a = 0, b = 0;
  Pose T_a_b = Pose::Identity();
  double sigma = 0;       // m, standard deviation per axis
  double sigma_turn = 0;  // rad, standard deviation per axis
  bool is_loop = false;   // found without the help of odometry: may be wrong
  /// The standard deviation per axis that is expected, m and rad. `sigma` is cautious: it decides what may be matched
  /// and how far a loop is looked for, where too little costs a doubled map. What a map says of its positions is made
  /// of these (map/drift.h). Negative: as sigma; a KeyframeGraph sets them.
  double expected = -1, expected_turn = -1;
};

/// The deviations of a constraint that says nothing: it ties a fragment of map, whose place is unknown, to the others.
inline constexpr double kAnywhere = 1000, kAnyTurn = std::numbers::pi;  // m, rad

inline bool isLoose(const BetweenConstraint& constraint) { return constraint.sigma >= kAnywhere; }

/// Inverse covariance (1/m^2, 1/rad^2): diagonal, its tangent being (translation, rotation vector) in frame a about b's
/// origin. Not finite where a standard deviation is zero.
inline Mat6 informationOf(const BetweenConstraint& constraint) {
  const double sigma = constraint.sigma, sigma_turn = constraint.sigma_turn;
  Mat6 information = Mat6::Zero();
  information.diagonal() << Vec3::Constant(1 / (sigma * sigma)), Vec3::Constant(1 / (sigma_turn * sigma_turn));
  return information;
}

}  // namespace hgg
