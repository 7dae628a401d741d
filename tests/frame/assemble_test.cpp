#include "frame/assemble.h"

#include <gtest/gtest.h>

namespace hgg::assemble_test {
namespace {

constexpr Micros kWait_us = 200'000;
constexpr Micros kPeriod_us = 100'000;

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
  FrameAssembler assembler(kWait_us);
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
  FrameAssembler assembler(kWait_us);
  assembler.addOdometry(odometryAt(0));
  assembler.addCloud(cloudAt(500), 10'000);
  EXPECT_FALSE(assembler.next(10'000));
  EXPECT_FALSE(assembler.next(10'000 + kWait_us));
  assembler.addOdometry(odometryAt(1000));
  EXPECT_EQ(takeAll(assembler, 10'000 + kWait_us), Times{500});
}

TEST(FrameAssembler, ACloudWithoutOdometryIsDroppedAfterTheWait) {
  FrameAssembler assembler(kWait_us);
  assembler.addOdometry(odometryAt(0));
  assembler.addCloud(cloudAt(500), 10'000);
  EXPECT_FALSE(assembler.next(10'000 + kWait_us + 1));
  EXPECT_EQ(assembler.drops().odometry, 1);
  assembler.addOdometry(odometryAt(1000));
  EXPECT_FALSE(assembler.next(10'000 + kWait_us + 2));
}

TEST(FrameAssembler, ACloudFromBeforeTheOdometryIsDroppedAtOnce) {
  FrameAssembler assembler(kWait_us);
  assembler.addOdometry(odometryAt(1000));
  assembler.addCloud(cloudAt(500), 0);
  EXPECT_FALSE(assembler.next(0));
  EXPECT_EQ(assembler.drops().odometry, 1);
}

TEST(FrameAssembler, SeveralWaitingCloudsComeInOrderOfTime) {
  FrameAssembler assembler(kWait_us);
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
  FrameAssembler assembler(kWait_us);
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
  FrameAssembler assembler(kWait_us);
  assembler.addCloud(cloudAt(1), 0);
  assembler.addCloud(cloudAt(2), 0);
  assembler.finish();
  EXPECT_EQ(assembler.drops().odometry, 2);
  EXPECT_FALSE(assembler.isWaiting());
}

TEST(FrameAssembler, WaitingCloudsAreBounded) {
  FrameAssembler assembler(Micros{1} << 50);
  for (Micros t = 1; t <= 1000; ++t) {
    assembler.addCloud(cloudAt(t), 0);
  }
  assembler.addOdometry(odometryAt(0));
  assembler.addOdometry(odometryAt(1000));
  const auto times_us = takeAll(assembler, 0);
  EXPECT_LT(times_us.size(), 100u);
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
  FrameAssembler assembler(kWait_us);
  EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
  EXPECT_EQ(drive(assembler, 1'000'000, 5, 500'000).size(), 5u);
  EXPECT_EQ(assembler.restarts(), 1);
  EXPECT_EQ(assembler.drops().total(), 0);
}

TEST(FrameAssembler, ACloudThatWaitsWhenTimeRestartsIsDropped) {
  FrameAssembler assembler(kWait_us);
  assembler.addCloud(cloudAt(100'000'000), 0);
  EXPECT_EQ(drive(assembler, 1'000'000, 5, 0).size(), 5u);
  EXPECT_EQ(assembler.drops().odometry, 1);
}

TEST(FrameAssembler, OneWrongCloudTimeCostsOneCloud) {
  for (const Micros wrong_us : {Micros{5}, Micros{1} << 60, Micros{103'000'000}}) {
    FrameAssembler assembler(kWait_us);
    EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
    assembler.addCloud(cloudAt(wrong_us), 500'000);
    const auto after = drive(assembler, 100'500'000, 10, 500'000);
    EXPECT_GE(after.size(), 6u) << wrong_us;  // deaf for the wait and the cloud that ends it
    EXPECT_EQ(after.back(), 101'400'000);
    EXPECT_EQ(assembler.restarts(), 0);
  }
}

TEST(FrameAssembler, OneWrongOdometryTimeDoesNotDeafen) {
  for (const Micros wrong_us : {Micros{5}, Micros{1} << 60}) {
    FrameAssembler assembler(kWait_us);
    EXPECT_EQ(drive(assembler, 100'000'000, 5, 0).size(), 5u);
    assembler.addOdometry(odometryAt(wrong_us));
    EXPECT_EQ(drive(assembler, 100'500'000, 10, 500'000).size(), 10u) << wrong_us;
  }
}

TEST(FrameAssembler, AClockOfArrivalThatGoesBackDoesNotMakeCloudsWaitForEver) {
  FrameAssembler assembler(kWait_us);
  assembler.addCloud(cloudAt(1), 1'000'000'000);
  EXPECT_FALSE(assembler.next(0));
  EXPECT_EQ(assembler.drops().odometry, 0);
  EXPECT_FALSE(assembler.next(kWait_us + 1));
  EXPECT_EQ(assembler.drops().odometry, 1);
}

}  // namespace
}  // namespace hgg::assemble_test
