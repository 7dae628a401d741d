#include "core/belief.h"

#include <algorithm>
#include <cmath>

#include "core/spd.h"

namespace hgg {

Belief Moments::belief() const {
  if (n_ == 0) {
    return {};
  }
  const Vec3 shift = Vec3(sum_[0], sum_[1], sum_[2]) / n_;
  Mat3 second;
  second << square_[0], square_[3], square_[4],  //
      square_[3], square_[1], square_[5],        //
      square_[4], square_[5], square_[2];
  Belief b{origin_ + shift, second / n_ - shift * shift.transpose(), n_};
  // Rounding may leave a variance of a flat set slightly below zero.
  b.cov.diagonal() = b.cov.diagonal().cwiseMax(0.0);
  return b;
}

Belief beliefFromPoints(std::span<const Vec3> points) {
  if (points.empty()) {
    return {};
  }
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : points) {
    centre += p / static_cast<double>(points.size());
  }
  Moments moments(centre);
  for (const Vec3& p : points) {
    moments.add(p.x(), p.y(), p.z());
  }
  return moments.belief();
}

Belief merge(const Belief& a, const Belief& b) {
  const double kappa = a.kappa + b.kappa;
  if (kappa <= 0) {
    return a;
  }
  const double share_a = a.kappa / kappa, share_b = b.kappa / kappa;
  const Vec3 d = a.mean - b.mean;
  return {share_a * a.mean + share_b * b.mean,
          share_a * a.cov + share_b * b.cov + share_a * share_b * d * d.transpose(), kappa};
}

Belief transform(const Pose& T_a_b, const Belief& b) {
  const Mat3 R = T_a_b.linear();
  return {T_a_b * b.mean, R * b.cov * R.transpose(), b.kappa};
}

Pose objectFrame(const Belief& belief) {
  const Eigen3 e = eigenSymmetric(belief.cov);
  Pose T = Pose::Identity();
  T.linear() << e.vectors.col(2), e.vectors.col(1), -e.vectors.col(0);
  T.translation() = belief.mean;
  return T;
}

Mat3 covarianceOfIndependentPoints(const Belief& b) { return b.cov / std::max(b.kappa, 1.0); }

double wasserstein2(const Belief& a, const Belief& b) {
  const double spread = a.cov.trace() + b.cov.trace() - 2 * nuclearNormOfRoots(a.cov, b.cov);
  return std::sqrt((a.mean - b.mean).squaredNorm() + std::max(spread, 0.0));
}

double edgeDistance(const Belief& a, const Belief& b, double sigma_floor) {
  const Mat3 cov_a = withFloor(a.cov, sigma_floor), cov_b = withFloor(b.cov, sigma_floor);
  return mahalanobis(a.mean - b.mean, 0.5 * (cov_a + cov_b)) + affineInvariantDistance(cov_a, cov_b);
}

double bhattacharyyaCoefficient(const Belief& a, const Belief& b, double sigma_floor) {
  const Mat3 cov_a = withFloor(a.cov, sigma_floor), cov_b = withFloor(b.cov, sigma_floor), s = 0.5 * (cov_a + cov_b);
  const double m = mahalanobis(a.mean - b.mean, s);
  const double log_ratio = std::log(s.determinant()) - 0.5 * std::log(cov_a.determinant() * cov_b.determinant());
  return std::exp(-m * m / 8 - log_ratio / 2);
}

}  // namespace hgg
