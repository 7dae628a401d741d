#include "alignment/propagation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "random_geometry.h"

namespace hgg::propagation_test {
namespace {

AlignmentConfig exactOdometry() {
  AlignmentConfig config;
  config.odometry_drift = config.odometry_turn_deg = config.odometry_jitter_deg = 0;
  config.odometry_jitter = 1e-6;
  return config;
}

TEST(PredictPose, CarriesUncertaintyAsSmallChangesOfTheLastPoseDo) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    Mat6 A;
    for (int k = 0; k < 36; ++k) {
      A(k / 6, k % 6) = uniform(random, -1, 1);
    }
    const Mat6 cov = 1e-4 * (A * A.transpose() + Mat6::Identity());
    const PoseBelief last{randomPose(random, 10), cov.inverse()};
    Pose T_last_body = Pose::Identity();
    T_last_body.translation() = randomVector(random, 3);
    T_last_body.rotate(Eigen::AngleAxisd(uniform(random, -1.5, 1.5), randomVector(random, 1).normalized()));
    const PoseBelief next = *propagatePose(last, T_last_body, odometryNoise(T_last_body, exactOdometry()));
    EXPECT_LT(localCoordinates(next.T_map_body, last.T_map_body * T_last_body).norm(), 1e-12);
    constexpr double kStep = 1e-6;
    Mat6 F;  // numeric: how the next pose moves with the last one
    for (int k = 0; k < 6; ++k) {
      const Pose changed = retract(last.T_map_body, kStep * Vec6::Unit(k)) * T_last_body;
      F.col(k) = localCoordinates(changed, next.T_map_body) / kStep;
    }
    const Mat6 expected = F * cov * F.transpose();
    EXPECT_LT((next.information.inverse() - expected).norm(), 1e-4 * expected.norm());
  }
}

TEST(PredictPose, GrowsWithTheWayAndTheTurn) {
  const PoseBelief start = startPose(Pose::Identity(), true);
  Pose near = Pose::Identity(), far = Pose::Identity(), turned = Pose::Identity();
  near.translation().x() = 0.1;
  far.translation().x() = 10;
  turned.rotate(Eigen::AngleAxisd(1, Vec3::UnitZ()));
  const auto deviations = [&](const Pose& motion) -> Vec6 {
    return propagatePose(start, motion, odometryNoise(motion, {}))->information.inverse().diagonal().cwiseSqrt();
  };
  EXPECT_NEAR(deviations(far)[0], 0.03 * 10 + 0.01, 0.01);  // the defaults
  EXPECT_LT(deviations(near)[0], 0.02);
  EXPECT_GT(deviations(turned)[5], 5 * deviations(near)[5]);
}

TEST(PredictPose, ARobotAtRestForADayStillKnowsWhereItIs) {
  PoseBelief pose = startPose(Pose::Identity(), true);
  for (int frame = 0; frame < 864'000; ++frame) {
    pose = *propagatePose(pose, Pose::Identity(), odometryNoise(Pose::Identity(), {}));
  }
  const Vec6 deviations = pose.information.inverse().diagonal().cwiseSqrt();
  EXPECT_LT(deviations.head<3>().maxCoeff(), 0.1);
  EXPECT_LT(deviations.tail<3>().maxCoeff(), 0.01);
}

TEST(PredictPose, AMotionNoRobotMakesIsNone) {
  const PoseBelief start = startPose(Pose::Identity(), true);
  Pose glitch = Pose::Identity();
  glitch.translation().x() = 1e7;
  EXPECT_FALSE(propagatePose(start, glitch, odometryNoise(glitch, {})));
  glitch.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(propagatePose(start, glitch, odometryNoise(glitch, {})));
}

}  // namespace
}  // namespace hgg::propagation_test
