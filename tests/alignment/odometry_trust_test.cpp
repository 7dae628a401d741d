#include "alignment/odometry_trust.h"

#include <gtest/gtest.h>

#include "core/units.h"

namespace hgg::odometry_trust_test {
namespace {

const AlignmentConfig kConfig;

/// A motion forward, turning left.
Pose motion(double metres, double degrees = 0) {
  Pose T = Pose::Identity();
  T.translation().x() = metres;
  T.rotate(Eigen::AngleAxisd(degrees * kDegree, Vec3::UnitZ()));
  return T;
}

/// `times` frames alike, in which constant velocity is right.
void learn(OdometryTrust& trust, const Pose& by_odometry, const Pose& aligned, int times = 1) {
  for (int k = 0; k < times; ++k) {
    trust.learn(by_odometry, aligned, aligned, kConfig);
  }
}

TEST(OdometryTrust, BeginsWithTheNoiseOfTheConfig) {
  const OdometryTrust trust;
  for (const Pose& T : {motion(1), motion(1, 5)}) {
    EXPECT_EQ(trust.noiseOf(T).position, 1);
    EXPECT_EQ(trust.noiseOf(T).turn, 1);
  }
  EXPECT_TRUE(trust.isBelieved());
}

TEST(OdometryTrust, NoiseRisesAtOnceAndFallsSlowly) {
  OdometryTrust trust;
  learn(trust, motion(1), motion(1.3));  // the config expects 4 cm
  const double risen = trust.noiseOf(motion(1)).position;
  EXPECT_GT(risen, 2);
  EXPECT_EQ(trust.noiseOf(motion(1)).turn, 1) << "it did not turn wrongly";
  learn(trust, motion(1), motion(1));
  EXPECT_LT(trust.noiseOf(motion(1)).position, risen);
  EXPECT_GT(trust.noiseOf(motion(1)).position, 0.97 * risen);
  learn(trust, motion(1), motion(1), 19);
  EXPECT_GT(trust.noiseOf(motion(1)).position, 0.7 * risen);
  learn(trust, motion(1), motion(1), 200);
  EXPECT_EQ(trust.noiseOf(motion(1)).position, 1);
}

TEST(OdometryTrust, NoiseTendsToWhatTheErrorsAre) {
  OdometryTrust trust;
  const double sigma = kConfig.odometry_drift + kConfig.odometry_jitter;  // over 1 m
  learn(trust, motion(1), motion(1 + 3 * sigma * std::sqrt(3.0)), 500);   // per axis 3 of them
  EXPECT_NEAR(trust.noiseOf(motion(1)).position, 3, 0.05);
}

TEST(OdometryTrust, NoiseIsNeverBelowTheConfigs) {
  OdometryTrust trust;
  for (const Pose& T : {motion(0), motion(1), motion(1, 5)}) {
    learn(trust, T, T, 300);
    EXPECT_EQ(trust.noiseOf(T).position, 1);
    EXPECT_EQ(trust.noiseOf(T).turn, 1);
  }
}

TEST(OdometryTrust, OneAbsurdFrameDoesNotDecideForLong) {
  OdometryTrust trust;
  learn(trust, motion(1), motion(1000));
  EXPECT_LE(trust.noiseOf(motion(1)).position, 30);
  learn(trust, motion(1), motion(1), 400);
  EXPECT_LT(trust.noiseOf(motion(1)).position, 1.5);
}

TEST(OdometryTrust, TurnsAndStraightMotionHaveNoiseOfTheirOwn) {
  OdometryTrust turns_badly, runs_badly;
  learn(turns_badly, motion(1, 5), motion(1, 8));
  EXPECT_GT(turns_badly.noiseOf(motion(1, 5)).turn, 2);
  EXPECT_EQ(turns_badly.noiseOf(motion(1)).turn, 1);
  learn(runs_badly, motion(1), motion(1.3));
  EXPECT_GT(runs_badly.noiseOf(motion(1)).position, 2);
  EXPECT_EQ(runs_badly.noiseOf(motion(1, 5)).position, 1);
}

TEST(OdometryTrust, AtRestTheNoiseOfAlignmentIsNoErrorOfOdometry) {
  OdometryTrust trust;
  for (int k = 0; k < 100; ++k) {
    learn(trust, motion(0), motion(k % 2 == 0 ? 0.005 : -0.005, 0.02));
  }
  EXPECT_LT(trust.noiseOf(motion(0)).position, 1.1);
  EXPECT_TRUE(trust.isBelieved());
}

TEST(OdometryTrust, FrozenOdometryIsDisbelieved) {
  OdometryTrust trust;
  learn(trust, motion(0.5), motion(0.5), 20);
  EXPECT_TRUE(trust.isBelieved());
  learn(trust, motion(0), motion(0.5));
  EXPECT_FALSE(trust.isBelieved());
}

TEST(OdometryTrust, IsBelievedAgainWhenItPredictsBetterThanConstantVelocity) {
  OdometryTrust trust;
  learn(trust, motion(0), motion(0.5), 10);
  ASSERT_FALSE(trust.isBelieved());
  int frames = 0;
  for (; frames < 100 && !trust.isBelieved(); ++frames) {  // the robot speeds up and slows down
    trust.learn(motion(0.5), motion(frames % 2 == 0 ? 0.45 : 0.55), motion(0.5), kConfig);
  }
  EXPECT_GT(frames, 3) << "a single right step is no proof";
  EXPECT_LT(frames, 60);
}

TEST(OdometryTrust, OdometryStaysBelievedWhereConstantVelocityIsNoBetter) {
  OdometryTrust trust;
  for (int k = 0; k < 100; ++k) {  // both are wrong by half
    trust.learn(motion(0.25), motion(0.25), motion(0.5), kConfig);
    EXPECT_TRUE(trust.isBelieved());
  }
}

TEST(OdometryTrust, ErrorsOfConstantVelocityAreInDeviationsOfTheConfigsOdometry) {
  OdometryTrust trust;
  EXPECT_EQ(trust.velocityErrors().position, 0);
  const double sigma = kConfig.odometry_drift + kConfig.odometry_jitter;
  for (int k = 0; k < 100; ++k) {
    trust.learn(motion(1), motion(1 + 2 * sigma * std::sqrt(3.0)), motion(1), kConfig);
  }
  EXPECT_NEAR(trust.velocityErrors().position, 2, 0.02);
  EXPECT_EQ(trust.velocityErrors().turn, 0);
}

TEST(OdometryTrust, AScaledConfigHasEveryNoiseMultiplied) {
  const AlignmentConfig out = scaled(kConfig, {2, 3});
  EXPECT_DOUBLE_EQ(out.odometry_drift, 3 * kConfig.odometry_drift);  // it is of both: the larger one
  EXPECT_DOUBLE_EQ(out.odometry_jitter, 2 * kConfig.odometry_jitter);
  EXPECT_DOUBLE_EQ(out.odometry_turn_deg, 3 * kConfig.odometry_turn_deg);
  EXPECT_DOUBLE_EQ(out.odometry_jitter_deg, 3 * kConfig.odometry_jitter_deg);
  EXPECT_EQ(out.gate, kConfig.gate);
}

}  // namespace
}  // namespace hgg::odometry_trust_test
