#include "alignment/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "core/so3.h"

namespace hgg {
namespace {

constexpr int kMaxIterations = 30;   // chosen by hand, not measured; what has converged ends earlier
constexpr double kConverged = 1e-5;  // m and rad, a thousandth of the deviation of a single leaf
/// Levenberg-Marquardt's damping: ten times more after a step that failed, ten times less after one that succeeded, as
/// Marquardt (1963) has it. The bounds were chosen by hand: the least damping does nothing, and the first that a failed
/// step asks for does a little.
constexpr double kFirstDamping = 1e-6, kDampingRise = 10, kDampingFall = 0.1, kLeastDamping = 1e-9,
                 kLeastRaisedDamping = 1e-4;
/// Share of the largest diagonal entry that keeps the system regular.
constexpr double kRegular = 1e-12;

/// The terms of one pair: d = R mu_i + t - mu_j and y = W d.
struct Term {
  Vec3 arm;  // R mu_i
  Mat3 cov_turned, W;
  Vec3 d, y;

  Term(const GaussianPair& pair, const Pose& T)
      : arm(T.linear() * pair.mean_body),
        cov_turned(T.linear() * pair.cov_body * T.linear().transpose()),
        W((pair.cov_map + cov_turned).inverse()),
        d(arm + T.translation() - pair.mean_map),
        y(W * d) {}
  double square() const { return d.dot(y); }
};

using Terms = std::vector<Term>;

void fillTerms(std::span<const GaussianPair> pairs, const Pose& T, Terms& terms) {
  terms.clear();
  for (const GaussianPair& pair : pairs) {
    terms.emplace_back(pair, T);
  }
}

double robustCost(const Terms& terms, double c2) {
  double cost = 0;
  for (const Term& term : terms) {
    cost += term.square() / (1 + term.square() / c2);
  }
  return cost;
}

/// Gradient and hessian; the cost is left to robustCost.
RegistrationSystem derivatives(const Terms& terms, double c2) {
  RegistrationSystem system;
  for (const Term& term : terms) {
    const double trust = 1 / (1 + term.square() / c2), slope = trust * trust;
    // d s = 2 y . dd - y^T dC y with dd = v + w x arm and dC = [w] C' + C' [w]^T.
    Vec6 gradient;
    gradient << term.y, term.arm.cross(term.y) + term.y.cross(term.cov_turned * term.y);
    Eigen::Matrix<double, 3, 6> J;
    J << Mat3::Identity(), -skew(term.arm);
    system.gradient += 2 * slope * gradient;
    system.hessian += 2 * slope * J.transpose() * term.W * J;
  }
  return system;
}

double priorCost(const PoseBelief& prior, const Pose& T) {
  const Vec6 xi = localCoordinates(T, prior.T_map_body);
  return xi.dot(prior.information * xi);
}

/// Adds the prior's derivatives to those of the pairs.
RegistrationSystem withPrior(const RegistrationSystem& of_pairs, double weight, const PoseBelief& prior,
                             const Pose& T) {
  const Vec6 xi = localCoordinates(T, prior.T_map_body);
  Mat6 J = Mat6::Identity();
  J.bottomRightCorner<3, 3>() = inverseLeftJacobian(xi.tail<3>());
  return {0, weight * of_pairs.gradient + 2 * J.transpose() * prior.information * xi,
          weight * of_pairs.hessian + 2 * J.transpose() * prior.information * J};
}

/// Marquardt's step. The floor keeps it finite in directions of which neither pairs nor prior say anything.
Vec6 dampedStep(const RegistrationSystem& system, double damping) {
  Mat6 A = system.hessian;
  const double floor = kRegular * std::max(A.diagonal().maxCoeff(), kRegular);
  A.diagonal() += damping * A.diagonal() + Vec6::Constant(floor);
  return A.ldlt().solve(-system.gradient);
}

}  // namespace

double registrationCost(std::span<const GaussianPair> pairs, const Pose& T_map_body) {
  double cost = 0;
  for (const GaussianPair& pair : pairs) {
    cost += Term(pair, T_map_body).square();
  }
  return cost;
}

RegistrationSystem linearize(std::span<const GaussianPair> pairs, const Pose& T_map_body, double robust_scale) {
  const double c2 = robust_scale * robust_scale;
  Terms terms;
  fillTerms(pairs, T_map_body, terms);
  RegistrationSystem system = derivatives(terms, c2);
  system.cost = robustCost(terms, c2);
  return system;
}

Registration registerPairs(std::span<const GaussianPair> pairs, double weight, const PoseBelief& prior,
                           const Pose& T_start, double robust_scale) {
  const double c2 = robust_scale * robust_scale;
  Registration result{T_start, Mat6::Zero(), false};
  Terms terms;
  terms.reserve(pairs.size());
  fillTerms(pairs, T_start, terms);
  RegistrationSystem of_pairs = derivatives(terms, c2);
  double cost = weight * robustCost(terms, c2) + priorCost(prior, T_start);
  double damping = kFirstDamping;
  for (int k = 0; k < kMaxIterations && !result.converged; ++k) {
    const Vec6 step = dampedStep(withPrior(of_pairs, weight, prior, result.T_map_body), damping);
    const Pose T = retract(result.T_map_body, step);
    fillTerms(pairs, T, terms);
    const double next_cost = weight * robustCost(terms, c2) + priorCost(prior, T);
    if (next_cost > cost) {
      damping = std::max(kDampingRise * damping, kLeastRaisedDamping);
      continue;
    }
    result.converged = step.cwiseAbs().maxCoeff() < kConverged;
    result.T_map_body = T;
    of_pairs = derivatives(terms, c2);
    cost = next_cost;
    damping = std::max(kDampingFall * damping, kLeastDamping);
  }
  result.information = 0.5 * weight * of_pairs.hessian;
  return result;
}

}  // namespace hgg
