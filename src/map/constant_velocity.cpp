#include "map/constant_velocity.h"

#include <Eigen/Cholesky>

namespace hgg {

ConstantVelocity seenAt(const Vec3& p, const Mat3& cov, const Mat3& velocity_cov) {
  ConstantVelocity state;
  state.mean.head<3>() = p;
  state.cov.topLeftCorner<3, 3>() = cov;
  state.cov.bottomRightCorner<3, 3>() = velocity_cov;
  return state;
}

ConstantVelocity predict(const ConstantVelocity& state, double dt, const Vec3& acceleration) {
  Mat6 F = Mat6::Identity();
  F.topRightCorner<3, 3>() = dt * Mat3::Identity();
  ConstantVelocity next{F * state.mean, F * state.cov * F.transpose()};
  // The integral of the noise over dt: position dt^3 / 3, velocity dt, and dt^2 / 2 between them.
  const Mat3 q = acceleration.asDiagonal();
  next.cov.topLeftCorner<3, 3>() += dt * dt * dt / 3 * q;
  next.cov.topRightCorner<3, 3>() += dt * dt / 2 * q;
  next.cov.bottomLeftCorner<3, 3>() += dt * dt / 2 * q;
  next.cov.bottomRightCorner<3, 3>() += dt * q;
  return next;
}

ConstantVelocity update(const ConstantVelocity& state, const Vec3& z, const Mat3& R) {
  const Mat3 S = state.positionCov() + R;
  const Eigen::Matrix<double, 6, 3> PH = state.cov.leftCols<3>();
  const Eigen::Matrix<double, 6, 3> K = S.llt().solve(PH.transpose()).transpose();
  ConstantVelocity next{state.mean + K * (z - state.position()), state.cov - K * PH.transpose()};
  next.cov = 0.5 * (next.cov + next.cov.transpose()).eval();
  return next;
}

double innovationSquare(const ConstantVelocity& state, const Vec3& z, const Mat3& R) {
  const Vec3 off = z - state.position();
  return off.dot(Mat3(state.positionCov() + R).llt().solve(off));
}

double motionSquare(const ConstantVelocity& state) {
  const Eigen::Vector2d v = state.mean.segment<2>(3);
  const Eigen::Matrix2d cov = state.cov.block<2, 2>(3, 3);
  return v.dot(cov.llt().solve(v));
}

ConstantVelocity transform(const Pose& T_a_b, const ConstantVelocity& state) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = T_a_b.linear();
  R.bottomRightCorner<3, 3>() = T_a_b.linear();
  ConstantVelocity moved{R * state.mean, R * state.cov * R.transpose()};
  moved.mean.head<3>() += T_a_b.translation();
  return moved;
}

}  // namespace hgg
