#include "alignment/tracker.h"

#include <gtest/gtest.h>

#include "core/units.h"

namespace hgg::tracker_test {
namespace {

constexpr Micros kFrame_us = 100'000;
const AlignmentConfig kConfig;
const Fit kGoodFit{100, 80}, kBadFit{100, 30};

Pose at(double x, double y = 0, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, y, 0);
  T.rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()));
  return T;
}

Alignment fitting(const Fit& fit, const Pose& T_map_body) {
  Alignment alignment;
  alignment.pose = {T_map_body, 1e4 * Mat6::Identity()};
  alignment.source = PoseSource::kAligned;
  alignment.fit = fit;
  return alignment;
}

/// A robot whose map's frame is (10, 5) and 90 degrees from odometry's.
struct Robot {
  Tracker tracker;
  Pose T_map_odom = at(10, 5, 90);
  Pose T_odom_true = Pose::Identity();  // what good odometry would say
  Micros now_us = 1'000'000;

  Frame frame(const Pose& T_odom_body) const { return {now_us, T_odom_body, {}}; }
  Prediction predict(const Pose& T_odom_body) { return tracker.predict(frame(T_odom_body), kConfig); }
  Pose truth() const { return T_map_odom * T_odom_true; }
  /// Laid on the map where it is.
  void accept(const Pose& T_odom_body) {
    const Alignment alignment = fitting(kGoodFit, truth());
    tracker.accept(frame(T_odom_body), alignment, alignment.pose, kConfig);
  }
  void go(const Pose& step) {
    now_us += kFrame_us;
    T_odom_true = T_odom_true * step;
  }
  /// Frames with good odometry; the first of all starts the drive.
  void drive(int frames, const Pose& step) {
    for (int k = 0; k < frames; ++k) {
      if (!tracker.hasStarted()) {
        tracker.startAt(frame(T_odom_true), {truth(), 1e4 * Mat6::Identity()});
      } else {
        go(step);
        predict(T_odom_true);
      }
      accept(T_odom_true);
    }
  }
};

void expectNear(const Pose& actual, const Pose& expected, double metres = 1e-6) {
  EXPECT_LT((actual.translation() - expected.translation()).norm(), metres) << actual.translation().transpose();
  EXPECT_LT(turnOf(actual.inverse() * expected), 1e-6);
}

TEST(Tracker, TheFirstFrameIsAStart) {
  Tracker tracker;
  EXPECT_FALSE(tracker.hasStarted());
  const Prediction prediction = tracker.predict({1, at(3), {}}, kConfig);
  EXPECT_TRUE(prediction.is_start);
  EXPECT_FALSE(prediction.is_unknown);
}

TEST(Tracker, GoesOnByOdometry) {
  Robot robot;
  robot.drive(10, at(0.1, 0, 2));
  robot.go(at(0.12, 0, 3));
  const Prediction prediction = robot.predict(robot.T_odom_true);
  expectNear(prediction.pose.T_map_body, robot.truth());
  EXPECT_FALSE(prediction.has_to_fit || prediction.is_disputed || prediction.is_unknown || prediction.is_start);
  ASSERT_EQ(prediction.guesses.size(), 2U);
  expectNear(prediction.guesses[0], robot.truth());
  EXPECT_EQ(robot.tracker.judge(prediction, fitting(kGoodFit, robot.truth())), Tracking::kHeld);
}

TEST(Tracker, IsLostAfterFiveFramesInARowThatDidNotFit) {
  Robot robot;
  robot.drive(10, at(0.1));
  for (int k = 0; k < 5; ++k) {
    robot.go(at(0.1));
    const Prediction prediction = robot.predict(robot.T_odom_true);
    EXPECT_FALSE(prediction.is_unknown);
    expectNear(prediction.pose.T_map_body, robot.truth());  // it goes on by odometry
    const Alignment alignment = fitting(kBadFit, robot.truth());
    ASSERT_EQ(robot.tracker.judge(prediction, alignment), Tracking::kDoubtful);
    EXPECT_EQ(robot.tracker.hold(robot.frame(robot.T_odom_true), prediction),
              k < 4 ? Tracking::kDoubtful : Tracking::kLost);
  }
  robot.go(at(0.1));
  EXPECT_TRUE(robot.predict(robot.T_odom_true).is_unknown);
  robot.tracker.startAt(robot.frame(robot.T_odom_true), {robot.truth(), Mat6::Identity()});
  robot.go(at(0.1));
  EXPECT_FALSE(robot.predict(robot.T_odom_true).is_unknown) << "a new fragment is a new start";
}

TEST(Tracker, AFrameThatFitsEndsTheDoubts) {
  Robot robot;
  robot.drive(10, at(0.1));
  for (int k = 0; k < 20; ++k) {
    robot.go(at(0.1));
    const Prediction prediction = robot.predict(robot.T_odom_true);
    ASSERT_FALSE(prediction.is_unknown);
    if (k % 5 == 4) {
      robot.accept(robot.T_odom_true);
    } else {
      EXPECT_EQ(robot.tracker.hold(robot.frame(robot.T_odom_true), prediction), Tracking::kDoubtful);
    }
  }
}

TEST(Tracker, LooksFartherTheLongerItDoubts) {
  Robot robot;
  robot.drive(10, at(0.1));
  double before = 0;
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(robot.tracker.reach(0.4).distance, before);
    before = robot.tracker.reach(0.4).distance;
    robot.go(at(0.1));
    robot.tracker.hold(robot.frame(robot.T_odom_true), robot.predict(robot.T_odom_true));
  }
  EXPECT_DOUBLE_EQ(Robot().tracker.reach(0.4).distance, 4.8);
  EXPECT_DOUBLE_EQ(Robot().tracker.reach(0.1).distance, 1.2);
}

TEST(Tracker, WhatASearchFindsMustFitThreeQuartersOfWhatIsUsual) {
  Robot robot;
  robot.drive(3, at(0.1));
  EXPECT_DOUBLE_EQ(robot.tracker.usualShare(), 0.8);
  EXPECT_DOUBLE_EQ(robot.tracker.leastShare(), 0.6);
}

TEST(Tracker, AStepThatNoRobotMakesHasToFit) {
  for (const Pose& jump : {at(50), at(5), at(0, -5), at(0.1, 0, 150)}) {  // in 0.1 s
    Robot robot;
    robot.T_odom_true = at(20);
    robot.drive(10, at(0.1));
    robot.go(at(0.1));
    const Prediction prediction = robot.predict(robot.T_odom_true * jump);
    EXPECT_TRUE(prediction.has_to_fit) << jump.translation().transpose();
    EXPECT_EQ(robot.tracker.judge(prediction, fitting(kGoodFit, robot.truth())), Tracking::kDoubtful);
  }
}

TEST(Tracker, AStepThatARobotCanMakeHasNot) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1));
  robot.go(at(0.2, 0, 30));  // it brakes and turns hard
  EXPECT_FALSE(robot.predict(robot.T_odom_true).has_to_fit);
}

TEST(Tracker, AnImpossibleStepGoesOnAtConstantVelocity) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1, 0, 1));
  robot.go(at(0.1, 0, 1));
  expectNear(robot.predict(at(500)).pose.T_map_body, robot.truth(), 1e-3);
}

TEST(Tracker, OdometryBackAtZeroHasBegunAnew) {
  Robot robot;
  robot.T_odom_true = at(20, 3, 40);
  robot.drive(10, at(0.1));
  robot.go(at(0.1));
  EXPECT_TRUE(robot.predict(at(0.1)).is_unknown);

  Robot near_zero;  // one that has always been there has not
  near_zero.T_odom_true = at(-0.4);
  near_zero.drive(20, at(0.02));
  near_zero.go(at(0.02));
  EXPECT_FALSE(near_zero.predict(near_zero.T_odom_true).is_unknown);
}

TEST(Tracker, OdometryThatSaysSoHasBegunAnew) {
  Robot robot;
  robot.drive(10, at(0.1));
  robot.go(at(0.1));
  Frame frame = robot.frame(robot.T_odom_true);
  frame.odometry_restarted = true;
  EXPECT_TRUE(robot.tracker.predict(frame, kConfig).is_unknown);
}

TEST(Tracker, OdometryThatComesBackFromAGlitchHasNotBegunAnew) {
  Robot robot;
  robot.T_odom_true = at(-0.3);
  robot.drive(10, at(0.02));
  robot.go(at(0.02));
  EXPECT_TRUE(robot.predict(at(100)).has_to_fit);
  robot.accept(at(100));  // the map has told where it is
  EXPECT_EQ(robot.tracker.odometryFault(), OdometryFault::kJump);
  robot.go(at(0.02));
  EXPECT_FALSE(robot.predict(robot.T_odom_true).is_unknown);
}

TEST(Tracker, CoastsWhileOdometryIsNotBelieved) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1, 0, 1));
  const Pose T_frozen = robot.T_odom_true;
  for (int k = 0; k < 10; ++k) {
    robot.go(at(0.1, 0, 1));
    robot.predict(T_frozen);
    robot.accept(T_frozen);
  }
  EXPECT_FALSE(robot.tracker.odometry().isBelieved());
  EXPECT_EQ(robot.tracker.odometryFault(), OdometryFault::kFrozen);
  const Pose T_last = robot.truth();
  robot.go(at(0.1, 0, 1));
  const Prediction prediction = robot.predict(T_frozen);
  expectNear(prediction.pose.T_map_body, robot.truth());
  ASSERT_EQ(prediction.guesses.size(), 2U);
  expectNear(prediction.guesses[1], T_last);  // what odometry says
}

TEST(Tracker, OdometryThatSuddenlyStopsIsDisputed) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1));
  const Pose T_stopped = robot.T_odom_true, T_last = robot.truth();
  robot.go(at(0.1));
  const Prediction prediction = robot.predict(T_stopped);
  EXPECT_TRUE(prediction.is_disputed);
  ASSERT_EQ(prediction.guesses.size(), 2U);
  expectNear(prediction.guesses[0], T_last);
  expectNear(prediction.guesses[1], robot.truth());
  EXPECT_FALSE(robot.predict(robot.T_odom_true).is_disputed);
}

TEST(Tracker, FirstStepsOfADriveAreNotDisputed) {
  Robot robot;
  robot.drive(4, at(0.1));
  EXPECT_FALSE(robot.predict(robot.T_odom_true).is_disputed);
}

TEST(Tracker, MotionInTheFirstStepsOfADriveIsUnproven) {
  for (const int frames : {1, 2, 5}) {
    Robot robot;
    robot.drive(frames, at(0.3));
    robot.go(at(0.3));
    EXPECT_TRUE(robot.predict(robot.T_odom_true).is_unproven) << frames;
  }
  Robot robot;
  robot.drive(6, at(0.3));
  robot.go(at(0.3));
  EXPECT_FALSE(robot.predict(robot.T_odom_true).is_unproven) << "the map has confirmed five steps";
  Robot proven;
  proven.drive(2, at(0.3));
  proven.tracker.proveOdometry();
  proven.go(at(0.3));
  EXPECT_FALSE(proven.predict(proven.T_odom_true).is_unproven);
  Robot resting;
  resting.drive(2, Pose::Identity());
  resting.go(Pose::Identity());
  EXPECT_FALSE(resting.predict(resting.T_odom_true).is_unproven) << "there is nothing to prove at rest";
}

TEST(Tracker, OdometrysPoseOfTheFrameBeforeMayBeAnotherNow) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1));
  const Pose T_rebase = at(-3, 7, 30);  // as after another delay has been applied, but more
  Frame frame = robot.frame(Pose::Identity());
  frame.T_odom_before = T_rebase * robot.T_odom_true;
  robot.go(at(0.11, 0, 1));
  frame.utime_us = robot.now_us;
  frame.T_odom_body = T_rebase * robot.T_odom_true;
  const Prediction prediction = robot.tracker.predict(frame, kConfig);
  expectNear(prediction.pose.T_map_body, robot.truth());
  EXPECT_FALSE(prediction.has_to_fit || prediction.is_unknown || prediction.is_disputed);
  const Alignment alignment = fitting(kGoodFit, robot.truth());
  robot.tracker.accept(frame, alignment, alignment.pose, kConfig);
  EXPECT_EQ(robot.tracker.odometryFault(), OdometryFault::kNone) << "which is no jump";
}

TEST(Tracker, ACorrectionMovesWhereItGoesOnFrom) {
  Robot robot;
  robot.T_odom_true = at(20);
  robot.drive(10, at(0.1));
  robot.T_map_odom = at(-4, 2, 10);
  robot.tracker.moveTo({robot.truth(), Mat6::Identity()});
  robot.go(at(0.1));
  expectNear(robot.predict(robot.T_odom_true).pose.T_map_body, robot.truth());
  expectNear(*robot.tracker.motionTo(robot.truth()), at(0.1));
}

TEST(Tracking, EveryStateHasAName) {
  EXPECT_STREQ(nameOf(Tracking::kHeld), "tracking");
  EXPECT_STREQ(nameOf(Tracking::kRecovered), "recovered");
  EXPECT_STREQ(nameOf(Tracking::kDoubtful), "doubtful");
  EXPECT_STREQ(nameOf(Tracking::kLost), "lost");
}

}  // namespace
}  // namespace hgg::tracker_test
