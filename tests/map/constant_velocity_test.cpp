#include "map/constant_velocity.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>
#include <vector>

#include "random_geometry.h"

namespace hgg::constant_velocity_test {
namespace {

struct Look {
  double dt = 0;  // since the last one, s
  Vec3 z;
  Mat3 R;
};

std::vector<Look> looks(std::mt19937& random, int number) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal;
  std::vector<Look> all;
  for (int k = 0; k < number; ++k) {
    const Mat3 A = Mat3::NullaryExpr([&] { return normal(random); });
    all.push_back({k == 0 ? 0 : 0.05 + unit(random),
                   Vec3(k, 0.3 * k, 0) + Vec3::NullaryExpr([&] { return normal(random); }),
                   A * A.transpose() + 0.1 * Mat3::Identity()});
  }
  return all;
}

/// The same estimate by one least-squares problem over the states at all looks: the normal equations hold the prior of
/// the first state, what the model says of each step, and each look.
ConstantVelocity batch(const std::vector<Look>& all, const Mat3& velocity_cov, const Vec3& q) {
  const auto n = static_cast<Eigen::Index>(all.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(6 * n);
  information.block<3, 3>(3, 3) += velocity_cov.inverse();
  for (Eigen::Index k = 0; k < n; ++k) {
    const Look& look = all[static_cast<std::size_t>(k)];
    const Mat3 W = look.R.inverse();
    information.block<3, 3>(6 * k, 6 * k) += W;
    vector.segment<3>(6 * k) += W * look.z;
    if (k > 0) {
      const double dt = look.dt;
      Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();  // x_k - F x_(k-1)
      J.leftCols<6>() = -Mat6::Identity();
      J.block<3, 3>(0, 3) = -dt * Mat3::Identity();
      J.rightCols<6>() = Mat6::Identity();
      Mat6 Q;
      const Mat3 D = q.asDiagonal();
      Q << dt * dt * dt / 3 * D, dt * dt / 2 * D, dt * dt / 2 * D, dt * D;
      information.block<12, 12>(6 * (k - 1), 6 * (k - 1)) += J.transpose() * Q.inverse() * J;
    }
  }
  const Eigen::MatrixXd cov = information.inverse();
  return {(cov * vector).tail<6>(), cov.bottomRightCorner<6, 6>()};
}

TEST(ConstantVelocity, IsTheLeastSquaresEstimateOverAllLooks) {
  const Mat3 velocity_cov = Vec3(25, 16, 1).asDiagonal();
  const Vec3 q(0.5, 0.3, 0.02);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const std::vector<Look> all = looks(random, 8);
    ConstantVelocity state = seenAt(all[0].z, all[0].R, velocity_cov);
    for (std::size_t k = 1; k < all.size(); ++k) {
      state = update(predict(state, all[k].dt, q), all[k].z, all[k].R);
    }
    const ConstantVelocity expected = batch(all, velocity_cov, q);
    EXPECT_LE((state.mean - expected.mean).norm(), 1e-8) << seed;
    EXPECT_LE((state.cov - expected.cov).norm(), 1e-8) << seed;
  }
}

TEST(ConstantVelocity, TwoStepsOfPredictionAreOneLongStep) {
  const Vec3 q(0.5, 0.3, 0.02);
  std::mt19937 random(3);
  ConstantVelocity state = seenAt({1, 2, 3}, Mat3::Identity(), 4 * Mat3::Identity());
  state = update(predict(state, 0.3, q), {2, 2, 3}, 0.1 * Mat3::Identity());
  const ConstantVelocity twice = predict(predict(state, 0.4, q), 1.1, q), once = predict(state, 1.5, q);
  EXPECT_LE((twice.mean - once.mean).norm(), 1e-12);
  EXPECT_LE((twice.cov - once.cov).norm(), 1e-12);
}

TEST(ConstantVelocity, InnovationsOfATrueModelAreChiSquare) {
  const Vec3 q(0.5, 0.5, 0.05);
  const double dt = 0.1;
  std::normal_distribution<double> normal;
  std::mt19937 random(5);
  const auto noise = [&] { return Vec3::NullaryExpr([&] { return normal(random); }).eval(); };
  const Mat3 R = 0.04 * Mat3::Identity();
  double sum = 0;
  int number = 0;
  for (int run = 0; run < 200; ++run) {
    Vec3 p = Vec3::Zero(), v = 3 * noise();
    ConstantVelocity state = seenAt(p + 0.2 * noise(), R, 9 * Mat3::Identity());
    for (int k = 0; k < 20; ++k) {
      // A draw of the integrated noise: velocity with variance q dt, position given it with the rest.
      const Vec3 dv = (q * dt).cwiseSqrt().cwiseProduct(noise());
      p += dt * v + 0.5 * dt * dv + (q * (dt * dt * dt / 12)).cwiseSqrt().cwiseProduct(noise());
      v += dv;
      const Vec3 z = p + 0.2 * noise();
      state = predict(state, dt, q);
      sum += innovationSquare(state, z, R);
      ++number;
      state = update(state, z, R);
    }
  }
  EXPECT_NEAR(sum / number, 3, 0.15);  // 4000 draws of variance 6: five deviations are 0.19
}

TEST(ConstantVelocity, SaysOfWhatStandsThatItStands) {
  std::normal_distribution<double> normal;
  std::mt19937 random(6);
  const Vec3 q(0.25, 0.25, 0.01);
  int moving = 0;
  for (int run = 0; run < 200; ++run) {
    const auto look = [&] { return (0.2 * Vec3::NullaryExpr([&] { return normal(random); })).eval(); };
    const Mat3 R = 0.04 * Mat3::Identity();
    ConstantVelocity state = seenAt(look(), R, 25 * Mat3::Identity());
    for (int k = 0; k < 15; ++k) {
      state = update(predict(state, 0.1, q), look(), R);
    }
    moving += motionSquare(state) > 9.21 ? 1 : 0;  // one in a hundred
  }
  EXPECT_LE(moving, 6);
}

TEST(ConstantVelocity, TurnsWithItsFrame) {
  std::mt19937 random(7);
  const Pose T = randomPose(random, 5);
  const Mat3 R = Vec3(0.5, 0.1, 0.02).asDiagonal();
  const Vec3 q = Vec3::Constant(0.4);
  const auto follow = [&](const Pose& T_a_b) {
    ConstantVelocity state =
        seenAt(T_a_b * Vec3(1, 2, 0), T_a_b.linear() * R * T_a_b.linear().transpose(), 9 * Mat3::Identity());
    for (int k = 1; k < 5; ++k) {
      state = update(predict(state, 0.2, q), T_a_b * Vec3(1 + k, 2, 0.1 * k),
                     T_a_b.linear() * R * T_a_b.linear().transpose());
    }
    return state;
  };
  const ConstantVelocity turned = transform(T, follow(Pose::Identity())), expected = follow(T);
  EXPECT_LE((turned.mean - expected.mean).norm(), 1e-9);
  EXPECT_LE((turned.cov - expected.cov).norm(), 1e-9);
}

}  // namespace
}  // namespace hgg::constant_velocity_test
