#include "frame/assemble.h"

#include <gtest/gtest.h>

namespace hgg::assemble_test {
namespace {

constexpr Micros kWait_us = 200'000;
constexpr Micros kPeriod_us = 100'000;
const PairingLimits kLive{.wait_us = kWait_us};
const PairingLimits kFromALog{};

SemanticCloud cloudAt(Micros utime_us) { return {utime_us, {{1, 2, 3, 0, 10}}}; }

OdometrySample odometryAt(Micros utime_us) {
  OdometrySample sample{utime_us, Pose::Identity()};
  sample.T_odom_body.translation().x() = static_cast<double>(utime_us);
  return sample;
}

std::vector<Micros> takeAll(FrameAssembler& assembler, Micros now_us) {
  std::vector<Micros> times_us;
  while (const auto frame = assembler.next(now_us)) {
    times_us.push_back(frame->utime_us);
  }
  return times_us;
}

using Times = std::vector<Micros>;

TEST(FrameAssembler, AFrameHasItsCloudAndTheOdometryOfItsTime) {
  FrameAssembler assembler(kLive);
  assembler.addOdometry(odometryAt(1000));
  assembler.addOdometry(odometryAt(3000));
  assembler.addCloud(cloudAt(1500), 0);
  const auto frame = assembler.next(0);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->utime_us, 1500);
  EXPECT_NEAR(frame->T_odom_body.translation().x(), 1500, 1e-9);
  ASSERT_EQ(frame->points.size(), 1u);
  EXPECT_EQ(frame->points[0].label, 10);
  EXPECT_EQ(assembler.drops().total(), 0);
}

TEST(FrameAssembler, OdometryThatComesWithinTheWaitIsUsed) {
  FrameAssembler assembler(kLive);
  assembler.addOdometry(odometryAt(0));
  assembler.addCloud(cloudAt(500), 10'000);
  EXPECT_FALSE(assembler.next(10'000));
  EXPECT_FALSE(assembler.next(10'000 + kWait_us));
  assembler.addOdometry(odometryAt(1000));
  EXPECT_EQ(takeAll(assembler, 10'000 + kWait_us), Times{500});
}

TEST(FrameAssembler, ACloudWithoutOdometryIsDroppedAfterTheWait) {
  FrameAssembler assembler(kLive);
  assembler.addOdometry(odometryAt(0));
  assembler.addCloud(cloudAt(500), 10'000);
  EXPECT_FALSE(assembler.next(10'000 + kWait_us + 1));
  EXPECT_EQ(assembler.drops().odometry, 1);
  assembler.addOdometry(odometryAt(1000));
  EXPECT_FALSE(assembler.next(10'000 + kWait_us + 2));
}

TEST(FrameAssembler, ACloudFromBeforeTheOdometryIsDroppedAtOnce) {
  FrameAssembler assembler(kLive);
  assembler.addOdometry(odometryAt(1000));
  assembler.addCloud(cloudAt(500), 0);
  EXPECT_FALSE(assembler.next(0));
  EXPECT_EQ(assembler.drops().odometry, 1);
}

TEST(FrameAssembler, SeveralWaitingCloudsComeInOrderOfTime) {
  FrameAssembler assembler(kLive);
  for (const Micros t : {1000, 2000, 3000}) {
    assembler.addCloud(cloudAt(t), t);
  }
  assembler.addOdometry(odometryAt(900));
  assembler.addOdometry(odometryAt(2500));
  EXPECT_EQ(takeAll(assembler, 3000), (Times{1000, 2000}));
  assembler.addOdometry(odometryAt(3000));
  EXPECT_EQ(takeAll(assembler, 3000), Times{3000});
}

TEST(FrameAssembler, LateAndDuplicateCloudsAreInvalid) {
  FrameAssembler assembler(kLive);
  assembler.addOdometry(odometryAt(0));
  assembler.addOdometry(odometryAt(500'000));
  assembler.addCloud(cloudAt(200'000), 0);
  assembler.addCloud(cloudAt(200'000), 0);  // while the first still waits
  EXPECT_EQ(takeAll(assembler, 0), Times{200'000});
  assembler.addCloud(cloudAt(200'000), 0);  // after it has gone
  assembler.addCloud(cloudAt(100'000), 0);
  EXPECT_EQ(takeAll(assembler, 0), Times{});
  EXPECT_EQ(assembler.drops().invalid, 3);
  assembler.addCloud(cloudAt(300'000), 0);
  EXPECT_EQ(takeAll(assembler, 0), Times{300'000});
}

TEST(FrameAssembler, FinishGivesUpOnWaitingClouds) {
  FrameAssembler assembler(kLive);
  assembler.addCloud(cloudAt(1), 0);
  assembler.addCloud(cloudAt(2), 0);
  assembler.finish();
  EXPECT_FALSE(assembler.next(0));
  EXPECT_EQ(assembler.drops().odometry, 2);
  EXPECT_EQ(assembler.drops().causes.at("odometry: there is none"), 2);
  EXPECT_FALSE(assembler.isWaiting());
}

TEST(FrameAssembler, WaitingCloudsAreBounded) {
  FrameAssembler assembler(kFromALog);
  for (Micros t = 1; t <= 1000; ++t) {
    assembler.addCloud(cloudAt(t), 0);
  }
  assembler.addOdometry(odometryAt(0));
  assembler.addOdometry(odometryAt(1000));
  const auto times_us = takeAll(assembler, 0);
  EXPECT_LT(times_us.size(), 200u);
  EXPECT_EQ(times_us.back(), 1000);
  EXPECT_EQ(assembler.drops().odometry, 1000 - std::ssize(times_us));
}

/// Feeds odometry and a cloud of the same time, 10 Hz; returns the frames that came out.
Times drive(FrameAssembler& assembler, Micros start_us, int frames, Micros arrival_us) {
  Times out;
  for (int i = 0; i < frames; ++i) {
    assembler.addOdometry(odometryAt(start_us + i * kPeriod_us));
    assembler.addCloud(cloudAt(start_us + i * kPeriod_us), arrival_us + i * kPeriod_us);
    for (const Micros t : takeAll(assembler, arrival_us + i * kPeriod_us)) {
      out.push_back(t);
    }
  }
  return out;
}

TEST(FrameAssembler, ARestartDoesNotDeafen) {
  FrameAssembler assembler(kLive);
  EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
  EXPECT_EQ(drive(assembler, 1'000'000, 5, 500'000).size(), 5u);
  EXPECT_EQ(assembler.restarts(), 1);
  EXPECT_EQ(assembler.drops().total(), 0);
}

TEST(FrameAssembler, ACloudThatWaitsWhenTimeRestartsIsDropped) {
  FrameAssembler assembler(kLive);
  assembler.addCloud(cloudAt(100'000'000), 0);
  EXPECT_EQ(drive(assembler, 1'000'000, 5, 0).size(), 5u);
  EXPECT_EQ(assembler.drops().odometry, 1);
}

TEST(FrameAssembler, OneWrongCloudTimeCostsOneCloud) {
  for (const Micros wrong_us : {Micros{5}, Micros{1} << 60, Micros{103'000'000}, Micros{108'400'000}}) {
    for (const PairingLimits& limits : {kLive, kFromALog}) {
      FrameAssembler assembler(limits);
      EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
      assembler.addCloud(cloudAt(wrong_us), 500'000);
      EXPECT_EQ(drive(assembler, 100'500'000, 10, 500'000).size(), 10u) << wrong_us;
      EXPECT_EQ(assembler.restarts(), 0);
      EXPECT_EQ(assembler.drops().causes.at("cloud: stamp out of line with those around it"), 1);
    }
  }
}

TEST(FrameAssembler, OneWrongOdometryTimeCostsNoCloud) {
  for (const Micros wrong_us : {Micros{5}, Micros{1} << 60, Micros{102'000'000}, Micros{108'400'000}}) {
    FrameAssembler assembler(kLive);
    EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
    assembler.addOdometry(odometryAt(wrong_us));
    EXPECT_EQ(drive(assembler, 100'500'000, 10, 500'000).size(), 10u) << wrong_us;
    EXPECT_EQ(assembler.odometry().counts().outliers, 1);
  }
}

TEST(FrameAssembler, FromALogCloudsWaitForSlowOdometry) {
  FrameAssembler log(kFromALog), live(kLive);
  for (int i = 0; i <= 60; ++i) {
    for (FrameAssembler* assembler : {&log, &live}) {
      if (i % 20 == 0) {
        assembler->addOdometry(odometryAt(i * kPeriod_us));
      }
      assembler->addCloud(cloudAt(i * kPeriod_us + 1000), i * kPeriod_us);
    }
    takeAll(live, i * kPeriod_us);
    if (i % 20 == 0) {
      takeAll(log, i * kPeriod_us);
    }
  }
  log.finish();
  takeAll(log, 60 * kPeriod_us);
  EXPECT_EQ(log.drops().total(), 1);  // the last, behind the last odometry
  EXPECT_GT(live.drops().causes.at("odometry: none came within frame.odometry_wait_ms"), 40);
}

TEST(FrameAssembler, ACloudInAGapOfOdometryIsDroppedAndTheGapTold) {
  FrameAssembler assembler({.wait_us = {}, .max_gap_us = 1'000'000});
  assembler.addOdometry(odometryAt(0));
  assembler.addCloud(cloudAt(500), 0);
  assembler.addOdometry(odometryAt(1'500'000));
  assembler.addOdometry(odometryAt(1'600'000));
  EXPECT_EQ(takeAll(assembler, 0), Times{});
  EXPECT_EQ(assembler.drops().causes.at("odometry: in a gap longer than frame.odometry_gap_s"), 1);
  EXPECT_EQ(assembler.longestGap_us(), 1'500'000);
}

/// Like drive(), with the flags of the frames: which of them came after odometry began anew.
std::vector<bool> restartsIn(FrameAssembler& assembler, Micros start_us, int frames, int odometry_every = 1) {
  std::vector<bool> out;
  for (int i = 0; i < frames; ++i) {
    if (i % odometry_every == 0) {
      assembler.addOdometry(odometryAt(start_us + i * kPeriod_us));
    }
    assembler.addCloud(cloudAt(start_us + i * kPeriod_us), 0);
    while (const auto frame = assembler.next(0)) {
      EXPECT_NEAR(frame->T_odom_body.translation().x(), static_cast<double>(frame->utime_us), 1e-6);
      out.push_back(frame->odometry_restarted);
    }
  }
  return out;
}

TEST(FrameAssembler, TheFirstFrameAfterOdometryBeganAnewSaysSo) {
  for (const Micros step_us : {Micros{-5'000'000}, Micros{-3'600'000'000}, Micros{36'000'000}}) {
    FrameAssembler assembler(kFromALog);
    EXPECT_EQ(restartsIn(assembler, 10'000'000'000, 3), (std::vector<bool>{false, false, false}));
    EXPECT_EQ(restartsIn(assembler, 10'000'000'000 + step_us, 3), (std::vector<bool>{true, false, false})) << step_us;
    EXPECT_EQ(assembler.drops().total(), 0);
  }
}

TEST(FrameAssembler, AShortGapIsNoNewOdometry) {
  FrameAssembler assembler(kFromALog);
  restartsIn(assembler, 1'000'000, 3);
  EXPECT_EQ(restartsIn(assembler, 2'000'000, 3), (std::vector<bool>{false, false, false}));
}

TEST(FrameAssembler, OdometryThatFellSilentForASecondIsNewOdometryOnce) {
  FrameAssembler assembler(kFromALog);
  restartsIn(assembler, 1'000'000, 3);
  EXPECT_EQ(restartsIn(assembler, 6'000'000, 3), (std::vector<bool>{true, false, false}));
}

// The old samples of these times are still there: they must not be taken for the new.
TEST(FrameAssembler, AfterAStepBackSlowOdometryIsWaitedFor) {
  FrameAssembler assembler(kFromALog);
  restartsIn(assembler, 100'000'000, 100, 5);
  const auto after = restartsIn(assembler, 105'000'000, 11, 5);
  EXPECT_EQ(after, (std::vector<bool>{true, false, false, false, false, false, false, false, false, false, false}));
}

TEST(FrameAssembler, CloudsWhoseClockAloneIsSetBackFindNoPose) {
  FrameAssembler assembler(kFromALog);
  restartsIn(assembler, 100'000'000, 20);
  for (int i = 20; i < 60; ++i) {
    assembler.addOdometry(odometryAt(100'000'000 + i * kPeriod_us));
    assembler.addCloud(cloudAt(98'000'000 + i * kPeriod_us), 0);
  }
  const auto frames = takeAll(assembler, 0);
  ASSERT_EQ(frames.size(), 20u);  // those of times not mapped yet
  EXPECT_EQ(frames.front(), 102'000'000);
  EXPECT_EQ(assembler.drops().causes.at("odometry: its clock was not set back with that of the clouds"), 20);
}

TEST(FrameAssembler, CloudsThatWaitWhenOdometryIsSetBackAreNotPairedWithTheNewTime) {
  FrameAssembler assembler(kFromALog);
  drive(assembler, 100'000'000, 5, 0);
  assembler.addCloud(cloudAt(100'500'000), 0);
  for (int i = 0; i < 100; ++i) {
    assembler.addOdometry(odometryAt(95'000'000 + i * kPeriod_us));
    EXPECT_EQ(takeAll(assembler, 0), Times{});
  }
  EXPECT_EQ(assembler.drops().causes.at("odometry: the clock was set back before it came"), 1);
}

TEST(FrameAssembler, AClockOfArrivalThatGoesBackDoesNotMakeCloudsWaitForEver) {
  FrameAssembler assembler(kLive);
  assembler.addCloud(cloudAt(1), 1'000'000'000);
  EXPECT_FALSE(assembler.next(0));
  EXPECT_EQ(assembler.drops().odometry, 0);
  EXPECT_FALSE(assembler.next(kWait_us + 1));
  EXPECT_EQ(assembler.drops().odometry, 1);
}

}  // namespace
}  // namespace hgg::assemble_test
