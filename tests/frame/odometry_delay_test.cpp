#include "frame/odometry_delay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/so3.h"
#include "core/units.h"
#include "random_geometry.h"

namespace hgg::odometry_delay_test {
namespace {

constexpr Micros kFrame_us = 100'000, kStart_us = 50'000'000;
constexpr Micros kGap_us = 500'000;

/// How a robot in a yard turns, rad at a time in s.
double weaving(double t) { return 0.5 * std::sin(0.9 * t) + 0.15 * std::sin(2.7 * t + 1); }
double straightOn(double) { return 0; }

Mat3 turned(double yaw) { return Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix(); }

/// A drive whose odometry has its own rate, noise and a delay: a sample stamped t is of the time t - delay.
struct Drive {
  double (*yaw)(double) = weaving;
  double delay = 0;                   // s
  Micros sample_us = 50'000;          // between samples
  double drift_deg = 0.05;            // of each sample's turn, one standard deviation
  double pause_every = 0, pause = 0;  // s: odometry is silent, and begins anew from zero
  std::mt19937 random{1};
  std::normal_distribution<double> normal{};

  OdometryDelay estimator{};
  OdometryBuffer odometry{kGap_us};
  double error = 0, zero = 0;  // rad: what odometry has drifted by, and where it began
  bool was_silent = false;

  void sample(Micros utime_us) {
    const double t = 1e-6 * static_cast<double>(utime_us);
    const bool is_silent = pause_every > 0 && std::fmod(t, pause_every) < pause;
    if (is_silent) {
      was_silent = true;
      return;
    }
    zero = was_silent ? yaw(t - delay) + error : zero;
    was_silent = false;
    error += drift_deg * kDegree * normal(random);
    Pose T = Pose::Identity();
    T.linear() = turned(yaw(t - delay) + error - zero);
    odometry.add({utime_us, T});
  }

  void run(double seconds) {
    Micros next_us = kStart_us;
    const auto end_us = kStart_us + static_cast<Micros>(1e6 * seconds);
    Mat3 R_last = turned(yaw(1e-6 * static_cast<double>(kStart_us)));
    for (Micros now_us = kStart_us; now_us < end_us; now_us += kFrame_us) {
      for (; next_us <= now_us; next_us += sample_us) {
        sample(next_us);
      }
      // Alignment knows the turn to 0.02 degrees.
      const Mat3 R = turned(yaw(1e-6 * static_cast<double>(now_us)) + 0.02 * kDegree * normal(random));
      estimator.add(now_us, Mat3(R_last.transpose() * R));
      R_last = R;
      estimator.compare(odometry);
    }
  }
  double applied() const { return 1e-6 * static_cast<double>(estimator.applied_us()); }
};

TEST(OdometryDelay, IsFoundToTenMilliseconds) {
  for (const Micros sample_us : {100'000, 50'000}) {
    for (const double delay : {0.1, -0.1, 0.06, 0.25}) {
      Drive drive;
      drive.delay = delay, drive.sample_us = sample_us;
      drive.run(90);
      EXPECT_NEAR(drive.applied(), delay, 0.01) << "samples every " << sample_us << " us";
      ASSERT_TRUE(drive.estimator.estimate());
      EXPECT_NEAR(drive.estimator.estimate()->delay, delay, 0.01);
      EXPECT_LT(std::abs(drive.estimator.estimate()->delay - delay), 4 * drive.estimator.estimate()->sigma + 2e-3);
    }
  }
}

TEST(OdometryDelay, WithoutOneNothingIsApplied) {
  for (const Micros sample_us : {100'000, 50'000, 33'000}) {
    for (const double drift_deg : {0.0, 0.05, 0.1}) {
      Drive drive;
      drive.sample_us = sample_us, drive.drift_deg = drift_deg;
      drive.run(180);
      EXPECT_EQ(drive.estimator.applied_us(), 0) << sample_us << " us, " << drift_deg << " degrees";
    }
  }
}

TEST(OdometryDelay, WheelsThatTurnPoorlyTellADelayOfAFrameInTheEnd) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    for (const double delay : {0.1, 0.0}) {
      Drive drive;
      drive.delay = delay, drive.sample_us = 100'000, drive.drift_deg = 0.6, drive.random.seed(seed);
      drive.run(120);
      EXPECT_NEAR(drive.applied(), delay, delay == 0 ? 0 : 0.02);
    }
  }
}

TEST(OdometryDelay, AnEstimateThatIsRoughIsAppliedOnceItIsCertain) {
  Drive drive;
  drive.delay = 0.2, drive.sample_us = 100'000, drive.drift_deg = 0.6;
  drive.run(40);
  ASSERT_TRUE(drive.estimator.estimate());
  EXPECT_GT(drive.estimator.estimate()->sigma, 0.01);
  EXPECT_NEAR(drive.applied(), 0.2, 0.05);
}

TEST(OdometryDelay, ThatOfAnEarlierSessionHoldsUntilTurnsShowAnother) {
  for (const double delay : {0.1, 0.0}) {
    Drive drive;
    drive.delay = delay;
    drive.estimator.startFrom(104'000);
    drive.run(4);
    EXPECT_EQ(drive.estimator.applied_us(), 104'000);
    drive.run(90);
    EXPECT_NEAR(drive.applied(), delay, delay == 0 ? 0 : 0.01);
  }
}

TEST(OdometryDelay, StraightDrivingTellsNothing) {
  for (const double delay : {0.0, 0.2}) {
    Drive drive;
    drive.yaw = straightOn, drive.delay = delay;
    drive.run(180);
    EXPECT_EQ(drive.estimator.applied_us(), 0);
    EXPECT_FALSE(drive.estimator.estimate());
  }
}

TEST(OdometryDelay, NothingIsAppliedBeforeItIsKnown) {
  Drive drive;
  drive.delay = 0.1;
  drive.run(4);
  EXPECT_EQ(drive.estimator.applied_us(), 0);
  EXPECT_FALSE(drive.estimator.estimate());
}

TEST(OdometryDelay, RestartsOfTheOdometryDoNotDisturb) {
  for (const double delay : {0.0, 0.1}) {
    Drive drive;
    drive.delay = delay, drive.pause_every = 40, drive.pause = 11;  // longer than kPause_us
    drive.run(200);
    EXPECT_GE(drive.odometry.counts().anew, 4);
    EXPECT_NEAR(drive.applied(), delay, delay == 0 ? 0 : 0.01);
  }
}

TEST(OdometryDelay, FramesThatAlignmentDidNotHoldDoNotDisturb) {
  OdometryDelay interrupted;  // every 15th frame is not aligned
  Drive other;
  other.delay = 0.1;
  Micros next_us = kStart_us;
  for (int k = 0; k < 900; ++k) {
    const Micros now_us = kStart_us + k * kFrame_us;
    for (; next_us <= now_us; next_us += other.sample_us) {
      other.sample(next_us);
    }
    const double t = 1e-6 * static_cast<double>(now_us);
    const Mat3 R = turned(weaving(t) - weaving(t - 0.1));
    interrupted.add(now_us, k % 15 == 0 ? std::nullopt : std::optional<Mat3>(R));
    interrupted.compare(other.odometry);
  }
  EXPECT_NEAR(1e-6 * static_cast<double>(interrupted.applied_us()), 0.1, 0.01);
}

}  // namespace
}  // namespace hgg::odometry_delay_test
