#pragma once

#include <span>
#include <vector>

#include "core/se3.h"
#include "core/types.h"

namespace hgg {

/// A Gaussian of the frame (body frame) and the Gaussian of the map (map frame) that it is matched with. Their
/// sum is positive-definite (floored), m^2; one of them may be zero where the other holds what is known of both.
struct GaussianPair {
  Vec3 mean_body = Vec3::Zero();
  Mat3 cov_body = Mat3::Identity();
  Vec3 mean_map = Vec3::Zero();
  Mat3 cov_map = Mat3::Identity();
};

/// eq. co_reg, summed over node and edge pairs alike: sum of |R mu_i + t - mu_j|^2 under (Sigma_j + R Sigma_i R^T)^-1.
double registrationCost(std::span<const GaussianPair> pairs, const Pose& T_map_body);

/// Derivatives of the robust cost sum_i s_i / (1 + s_i / c^2) (Geman-McClure) at a pose, s_i being the terms of eq.
/// co_reg and c = robust_scale. Pairs that are far off, like the other face of a wall, have next to no influence.
struct RegistrationSystem {
  double cost = 0;
  Vec6 gradient = Vec6::Zero();  // exact: the turn of Sigma_i is in it
  Mat6 hessian = Mat6::Zero();   // Gauss-Newton's
};
RegistrationSystem linearize(std::span<const GaussianPair> pairs, const Pose& T_map_body, double robust_scale);

struct Registration {
  Pose T_map_body = Pose::Identity();
  Mat6 information = Mat6::Zero();  // of the pairs alone, at the solution
  bool converged = false;
};

/// eq. regis: minimises the robust cost of the pairs, times `weight`, plus the prior's xi^T information xi, by
/// Levenberg-Marquardt from `T_start`. Without pairs the result is the prior's pose.
Registration registerPairs(std::span<const GaussianPair> pairs, double weight, const PoseBelief& prior,
                           const Pose& T_start, double robust_scale);

}  // namespace hgg
