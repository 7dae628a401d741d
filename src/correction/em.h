#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/belief.h"

namespace hgg {

/// Topology-constrained MAP-EM on the leaves of one object (eqs. e-step, m-step-mu, m-step-sigma). Everything is in the
/// object frame, in m; number and order of the leaves never change, so edges between them stay valid.
///
/// What never falls: with C_k the covariance, its eigenvalues raised to lambda, w = point_weight and the belief from
/// before the window (evidence k_k, m_k, S_k) as k_k pseudo-points, i.e. NIW(nu = k_k - 5) and Dirichlet(k_k + 1) at
/// their mode,
///   J = w sum_l ln sum_{k in sight of l} pi_k N(x_l | mu_k, C_k) exp(-lambda/2 tr C_k^-1)
///       + sum_k k_k [ln pi_k - 1/2 ln|2 pi C_k| - 1/2 tr C_k^-1 (S_k + (m_k - mu_k)(m_k - mu_k)^T)].
/// "+ lambda I" is weighted by n, so it is no prior but a point known up to N(0, lambda I): E ln N(x + noise | mu, C) =
/// ln N(x | mu, C) - lambda/2 tr C^-1. Jensen's bound needs densities positive, not normalised, so EM with this factor
/// (e^-1.5 .. 1) in the E-step is exact, and raised eigenvalues are the M-step's maximiser under C >= lambda I. With
/// eq. e-step as printed, which lacks it, only lambda = 0 is monotone. Sight is found once a call: J stays.
struct EmOptions {
  double lambda = 1e-4;     // m^2, eq. m-step-sigma
  int iterations = 3;       // at least one is made
  double gate = 3;          // standard deviations: a point sees only leaves within it
  double point_weight = 1;  // how many measured points one given point stands for
};

struct EmResult {
  std::vector<Belief> leaves;         // as many and in the order of the prior
  double explained = 0;               // measured points some leaf explains: what evidence grew by over the prior
  std::size_t left_out = 0;           // given points beyond every leaf's gate
  std::vector<double> log_posterior;  // J of the leaves each iteration began with, up to a constant; never falls
};

/// Refines leaves by the window's points of their object. `prior`: each leaf without the window's points (evidence may
/// be 0); `start`: the same leaves as they are now, from which the iteration begins. A leaf without mass becomes its
/// prior, bit for bit; one that starts without evidence has no weight and gets no mass.
EmResult refineLeaves(std::span<const Belief> prior, std::span<const Belief> start, std::span<const Vec3> points,
                      const EmOptions& options);

/// Which leaves each point sees: those of point l are leaf[begin[l]] .. leaf[begin[l + 1] - 1], ascending.
struct Sight {
  std::vector<std::uint32_t> begin;  // points + 1
  std::vector<std::uint32_t> leaf;
};

/// Leaves with evidence no more than `gate` standard deviations (Mahalanobis, eigenvalues raised to lambda) away.
Sight findSight(std::span<const Belief> leaves, std::span<const Vec3> points, const EmOptions& options);

struct Responsibilities {
  std::vector<double> gamma;  // beside Sight::leaf; sums to 1 over the leaves of a point
  double log_likelihood = 0;  // of the points that see a leaf, each counted once
};

/// Eq. e-step over what each point sees, with weights pi_k = kappa_k / sum kappa and densities that carry the factor of
/// lambda above; lambda = 0 is the equation as printed.
Responsibilities eStep(std::span<const Belief> leaves, std::span<const Vec3> points, const Sight& sight, double lambda);

/// Eqs. m-step-mu and m-step-sigma, merged (eq. merge) with each leaf's prior; without prior evidence the equations as
/// printed. kappa of a leaf is that of its prior plus its mass.
std::vector<Belief> mStep(std::span<const Belief> prior, std::span<const Vec3> points, const Sight& sight,
                          std::span<const double> gamma, const EmOptions& options);

}  // namespace hgg
