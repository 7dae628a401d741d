#pragma once

#include "core/se3.h"

namespace hgg {

/// Where something is and how fast it moves, map frame, as far as its positions tell: the Gaussian (p, v) in m and m/s
/// of a Kalman filter of constant velocity. Between looks the velocity wanders as white-noise acceleration drives it.
struct ConstantVelocity {
  Vec6 mean = Vec6::Zero();
  Mat6 cov = Mat6::Zero();

  Vec3 position() const { return mean.head<3>(); }
  Vec3 velocity() const { return mean.tail<3>(); }
  Mat3 positionCov() const { return cov.topLeftCorner<3, 3>(); }
  Mat3 velocityCov() const { return cov.bottomRightCorner<3, 3>(); }
};

/// Seen once at `p`, known to `cov` (m^2); the velocity is zero to `velocity_cov` (m^2/s^2).
ConstantVelocity seenAt(const Vec3& p, const Mat3& cov, const Mat3& velocity_cov);

/// The belief `dt` seconds (not negative) later. `acceleration` is the spectral density of the white noise along each
/// axis, m^2/s^3: in one second it adds as much to the variance of the velocity.
ConstantVelocity predict(const ConstantVelocity& state, double dt, const Vec3& acceleration);

/// The belief after a look at position `z` with covariance R (m^2, positive definite).
ConstantVelocity update(const ConstantVelocity& state, const Vec3& z, const Mat3& R);

/// Squared Mahalanobis distance of such a look from where the state expects it: chi-square of three degrees of freedom
/// where the model holds.
double innovationSquare(const ConstantVelocity& state, const Vec3& z, const Mat3& R);

/// Squared Mahalanobis distance of the horizontal velocity from zero: chi-square of two degrees of freedom for what
/// stands.
double motionSquare(const ConstantVelocity& state);

/// The state as seen from another frame, T_a_b.
ConstantVelocity transform(const Pose& T_a_b, const ConstantVelocity& state);

}  // namespace hgg
