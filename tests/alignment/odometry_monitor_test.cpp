#include "alignment/odometry_monitor.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/units.h"
#include "random_geometry.h"

namespace hgg::odometry_monitor_test {
namespace {

Pose motion(const Vec3& way, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.translation() = way;
  T.rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()));
  return T;
}

/// What is told after `steps` steps alike.
OdometryFault after(const Pose& by_odometry, const Pose& aligned, int steps = 10) {
  OdometryMonitor monitor;
  for (int k = 0; k < steps; ++k) {
    monitor.learn(by_odometry, aligned);
  }
  return monitor.fault();
}

const Pose kForward = motion(Vec3(0.2, 0, 0)), kRest = Pose::Identity();

TEST(OdometryMonitor, GoodOdometryWithTwoPercentOfNoiseIsNoFault) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  OdometryMonitor monitor;
  for (int k = 0; k < 3000; ++k) {
    const double speed = 0.3 + 0.3 * std::sin(0.01 * k), turn = 6 * std::sin(0.03 * k);
    const Pose odometry =
        motion(Vec3(speed * (1 + noise(random)), speed * noise(random), 0), turn * (1 + noise(random)));
    monitor.learn(odometry, motion(Vec3(speed, 0, 0), turn));
    ASSERT_EQ(monitor.fault(), OdometryFault::kNone) << k;
  }
}

TEST(OdometryMonitor, AtRestThereIsNothingToTell) {
  std::mt19937 random(2);
  OdometryMonitor monitor;
  for (int k = 0; k < 1000; ++k) {  // alignment trembles by 5 mm, odometry does not
    monitor.learn(kRest, motion(randomVector(random, 0.005), uniform(random, -0.05, 0.05)));
    ASSERT_EQ(monitor.fault(), OdometryFault::kNone) << k;
  }
}

TEST(OdometryMonitor, ItIsFrozenWhenTheRobotMovesAndOdometryDoesNot) {
  EXPECT_EQ(after(kRest, kForward), OdometryFault::kFrozen);
  EXPECT_EQ(after(kRest, motion(Vec3::Zero(), 5)), OdometryFault::kFrozen) << "turning on the spot";
  EXPECT_NE(after(kForward, kRest), OdometryFault::kFrozen);
}

TEST(OdometryMonitor, AWrongLengthOfWayIsSlip) {
  for (const double share : {0.4, 0.7, 1.35, 1.6}) {
    EXPECT_EQ(after(motion(Vec3(0.2 * share, 0, 0)), kForward), OdometryFault::kSlip) << share;
  }
  for (const double share : {0.85, 1.0, 1.15}) {
    EXPECT_EQ(after(motion(Vec3(0.2 * share, 0, 0)), kForward), OdometryFault::kNone) << share;
  }
}

TEST(OdometryMonitor, AWrongDirectionIsTheAxes) {
  EXPECT_EQ(after(motion(Vec3(-0.2, 0, 0)), kForward), OdometryFault::kAxes) << "backwards";
  EXPECT_EQ(after(motion(Vec3(0, 0.2, 0)), kForward), OdometryFault::kAxes) << "sideways";
  EXPECT_EQ(after(motion(Vec3(0, 0, 0.2)), kForward), OdometryFault::kAxes) << "upwards";
  EXPECT_EQ(after(motion(Vec3(0.2, 0, 0), -5), motion(Vec3(0.2, 0, 0), 5)), OdometryFault::kAxes) << "other way round";
}

TEST(OdometryMonitor, AFewStepsTellNothing) {
  EXPECT_EQ(after(kRest, kForward, 3), OdometryFault::kNone);
  EXPECT_EQ(after(kRest, kForward, 4), OdometryFault::kFrozen);
}

TEST(OdometryMonitor, AFaultThatIsOverIsForgotten) {
  OdometryMonitor monitor;
  for (int k = 0; k < 50; ++k) {
    monitor.learn(kRest, kForward);
  }
  EXPECT_EQ(monitor.fault(), OdometryFault::kFrozen);
  for (int k = 0; k < 10; ++k) {
    monitor.learn(kForward, kForward);
  }
  EXPECT_EQ(monitor.fault(), OdometryFault::kNone);
}

TEST(OdometryMonitor, AJumpIsToldForAHundredSteps) {
  for (const Pose& T : {kForward, kRest}) {
    OdometryMonitor monitor;
    monitor.noteJump();
    for (int k = 0; k <= 100; ++k) {
      EXPECT_EQ(monitor.fault(), OdometryFault::kJump) << k;
      monitor.learn(T, T);
    }
    EXPECT_EQ(monitor.fault(), OdometryFault::kNone);
  }
}

TEST(OdometryMonitor, TheStepOfAJumpIsNotTakenForWrongAxes) {
  OdometryMonitor monitor;
  for (int k = 0; k < 10; ++k) {
    monitor.learn(kForward, kForward);
  }
  monitor.noteJump();
  monitor.learn(motion(Vec3(-30, 40, 0)), kForward);
  EXPECT_EQ(monitor.fault(), OdometryFault::kJump);
}

TEST(OdometryMonitor, JumpAfterJumpIsNoAccidentButTheAxes) {
  OdometryMonitor monitor;
  for (int k = 0; k < 10; ++k) {
    monitor.noteJump();
    monitor.learn(motion(Vec3(-0.4, 0.9, 0)), kForward);
    if (k >= 3) {  // before, there is too little to tell
      EXPECT_EQ(monitor.fault(), OdometryFault::kAxes) << k;
    }
  }
}

TEST(OdometryMonitor, EveryFaultHasACodeAndASentence) {
  std::set<std::string> codes, sentences;
  for (const auto fault : {OdometryFault::kJump, OdometryFault::kFrozen, OdometryFault::kSlip, OdometryFault::kAxes}) {
    codes.insert(codeOf(fault)), sentences.insert(describe(fault));
  }
  EXPECT_EQ(codes, (std::set<std::string>{"odometry_jump", "odometry_frozen", "odometry_slip", "odometry_axes"}));
  EXPECT_EQ(sentences.size(), 4U);
  EXPECT_FALSE(sentences.contains(""));
  EXPECT_STREQ(codeOf(OdometryFault::kNone), "");
  EXPECT_STREQ(describe(OdometryFault::kNone), "");
}

}  // namespace
}  // namespace hgg::odometry_monitor_test
