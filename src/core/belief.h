#pragma once

#include <span>

#include "core/types.h"

namespace hgg {

/// A Gaussian under the Normal-Inverse-Wishart belief NIW(mean, kappa, kappa * cov, nu = kappa + 4) (eq. niw):
/// E[mu] = mean, E[Sigma] = cov. `cov` is the physical extent (population covariance, m^2), `kappa` the evidence in
/// points, which adds up when beliefs merge. How well the mean is known is another matter: core/position_uncertainty.h.
struct Belief {
  Vec3 mean = Vec3::Zero();
  Mat3 cov = Mat3::Zero();
  double kappa = 0;
};

/// Running sums of points relative to `origin`: choose it near the points, so that covariances far from the map's
/// origin keep their digits.
class Moments {
 public:
  explicit Moments(const Vec3& origin) : origin_(origin) {}
  void add(double x, double y, double z) {
    const double dx = x - origin_.x(), dy = y - origin_.y(), dz = z - origin_.z();
    n_ += 1;
    sum_[0] += dx, sum_[1] += dy, sum_[2] += dz;
    square_[0] += dx * dx, square_[1] += dy * dy, square_[2] += dz * dz;
    square_[3] += dx * dy, square_[4] += dx * dz, square_[5] += dy * dz;
  }
  double count() const { return n_; }
  /// The belief at creation: sample mean, population covariance, kappa = points. Zero belief when empty.
  Belief belief() const;

 private:
  Vec3 origin_;
  double n_ = 0;
  double sum_[3] = {}, square_[6] = {};
};

Belief beliefFromPoints(std::span<const Vec3> points);
/// Conjugate merge (eq. merge): identical to pooling the raw points of both.
Belief merge(const Belief& a, const Belief& b);
/// The belief in frame a, given T_a_b and the belief in frame b.
Belief transform(const Pose& T_a_b, const Belief& b);
/// Object frame of a belief: origin at its mean, axes along the eigenvectors of its extent (x the longest),
/// right-handed.
Pose objectFrame(const Belief& belief);
/// Cov[mu] of the Normal-Inverse-Wishart belief, cov / kappa (m^2): how well the mean would be known if the points were
/// independent, which they are not. For comparison only; positionCovariance (core/position_uncertainty.h) is the model
/// that holds.
Mat3 covarianceOfIndependentPoints(const Belief& b);

/// 2-Wasserstein distance of the two Gaussians in m (eq. wass).
double wasserstein2(const Belief& a, const Belief& b);
/// S1 of eq. metric: Mahalanobis distance of the means under the mean covariance plus the affine-invariant distance of
/// the covariances; both covariances get sigma_floor first.
double edgeDistance(const Belief& a, const Belief& b, double sigma_floor);
/// Bhattacharyya coefficient of the two Gaussians, 0 (apart) .. 1 (same), with sigma_floor on both covariances.
double bhattacharyyaCoefficient(const Belief& a, const Belief& b, double sigma_floor);

}  // namespace hgg
