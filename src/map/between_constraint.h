#pragma once

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
};

/// Inverse covariance (1/m^2, 1/rad^2): diagonal, its tangent being (translation, rotation vector) in frame a about b's
/// origin. Not finite where a standard deviation is zero.
inline Mat6 informationOf(const BetweenConstraint& constraint) {
  const double sigma = constraint.sigma, sigma_turn = constraint.sigma_turn;
  Mat6 information = Mat6::Zero();
  information.diagonal() << Vec3::Constant(1 / (sigma * sigma)), Vec3::Constant(1 / (sigma_turn * sigma_turn));
  return information;
}

}  // namespace hgg
