#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/belief.h"
#include "core/types.h"

namespace hgg {

/// Seeded random geometry for property tests.

inline double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// 0 .. n - 1.
inline std::uint32_t below(std::mt19937& random, std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); }

inline Vec3 randomVector(std::mt19937& random, double extent) {
  const double x = uniform(random, -extent, extent), y = uniform(random, -extent, extent);
  return {x, y, uniform(random, -extent, extent)};
}

inline Mat3 randomRotation(std::mt19937& random) {
  const double angle = uniform(random, -3.1, 3.1);
  return Eigen::AngleAxisd(angle, (randomVector(random, 1) + Vec3(0, 0, 1e-3)).normalized()).toRotationMatrix();
}

inline Pose randomPose(std::mt19937& random, double extent) {
  Pose T = Pose::Identity();
  T.linear() = randomRotation(random);
  T.translation() = randomVector(random, extent);
  return T;
}

inline Mat3 rotatedDiagonal(const Mat3& R, const Vec3& values) {
  const Mat3 m = R * values.asDiagonal() * R.transpose();
  return 0.5 * (m + m.transpose());
}

/// Symmetric positive-definite with eigenvalues log-uniform in ratio .. 1, m^2.
inline Mat3 randomSpd(std::mt19937& random, double ratio) {
  const Mat3 R = randomRotation(random);
  Vec3 values;
  for (Eigen::Index k = 0; k < 3; ++k) {
    values[k] = std::exp(uniform(random, std::log(ratio), 0));
  }
  return rotatedDiagonal(R, values);
}

inline Belief randomBelief(std::mt19937& random, double extent) {
  const Vec3 mean = randomVector(random, extent);
  const Mat3 cov = randomSpd(random, 1e-3);
  return {mean, cov, static_cast<double>(std::uniform_int_distribution<int>(1, 500)(random))};
}

/// Points of an anisotropic blob around `centre`.
inline std::vector<Vec3> randomPoints(std::mt19937& random, int n, const Vec3& centre) {
  const Mat3 R = randomRotation(random);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(centre + R * randomVector(random, 1).cwiseProduct(Vec3(2, 0.5, 0.1)));
  }
  return points;
}

/// Largest relative difference, in the norm of the expected value.
template <typename A, typename B>
double relativeError(const Eigen::MatrixBase<A>& actual, const Eigen::MatrixBase<B>& expected) {
  return static_cast<double>((actual - expected).norm() / expected.norm());
}

}  // namespace hgg
