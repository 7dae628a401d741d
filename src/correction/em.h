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
/// An iteration never lowers the objective J. In it C_k is the covariance with its eigenvalues raised to lambda, w is
/// point_weight, and the belief from before the window (evidence k_k, m_k, S_k) counts as k_k pseudo-points, i.e. as
/// NIW(nu = k_k - 5) and Dirichlet(k_k + 1) at their mode:
///   J = w sum_l ln sum_{k in sight of l} pi_k N(x_l | mu_k, C_k) exp(-lambda/2 tr C_k^-1)
///       + sum_k k_k [ln pi_k - 1/2 ln|2 pi C_k| - 1/2 tr C_k^-1 (S_k + (m_k - mu_k)(m_k - mu_k)^T)].
/// The paper's "+ lambda I" is weighted by n, so it is not a prior: it says that each point is known up to N(0, lambda
/// I), for E ln N(x + noise | mu, C) = ln N(x | mu, C) - lambda/2 tr C^-1. Jensen's bound needs positive densities and
/// not normalised ones. EM with this factor (e^-1.5 .. 1) in the E-step is therefore exact, and raised eigenvalues
/// maximise the M-step under C >= lambda I. Eq. e-step as printed lacks the factor and is monotone for lambda = 0 only.
/// Which leaves a point sees is found once a call, so that J stays the same function.
struct EmOptions {
  double lambda = 1e-4;     // m^2, eq. m-step-sigma
  int iterations = 3;       // at least one is made
  double gate = 3;          // standard deviations: a point sees only leaves within it
  double point_weight = 1;  // measured points that one given point stands for
};

struct EmResult {
  std::vector<Belief> leaves;         // as many and in the order of the prior
  double explained = 0;               // measured points that some leaf explains: the evidence added to the prior
  std::size_t left_out = 0;           // given points beyond every leaf's gate
  std::vector<double> log_posterior;  // J of the leaves each iteration began with, up to a constant; never falls
};

/// Refines leaves by the window's points of their object. `prior` holds each leaf without the window's points (evidence
/// may be 0), `start` the same leaves as they are now, from which the iteration begins. A leaf without mass becomes its
/// prior, bit for bit. A leaf that starts without evidence has no weight and gets no mass.
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

/// Eqs. m-step-mu and m-step-sigma, merged (eq. merge) with each leaf's prior; without prior evidence these are the
/// equations as printed. The kappa of a leaf is that of its prior plus its mass.
std::vector<Belief> mStep(std::span<const Belief> prior, std::span<const Vec3> points, const Sight& sight,
                          std::span<const double> gamma, const EmOptions& options);

}  // namespace hgg
