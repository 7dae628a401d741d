#include "frame/odometry_buffer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hgg::odometry_buffer_test {
namespace {

Pose poseAt(double x, double yaw) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(x, 2 * x, 0);
  pose.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  return pose;
}

constexpr Micros kGap_us = 1'000'000;

OdometryBuffer bufferOf(std::initializer_list<Micros> times_us) {
  OdometryBuffer buffer(kGap_us);
  for (const Micros t : times_us) {
    buffer.add({t, poseAt(static_cast<double>(t), 0)});
  }
  return buffer;
}

TEST(OdometryBuffer, ExactHitIsReturnedBitForBit) {
  OdometryBuffer buffer(kGap_us);
  const Pose pose = poseAt(0.1, 0.3);
  buffer.add({100, poseAt(0, 0)});
  buffer.add({200, pose});
  buffer.add({300, poseAt(1, 1)});
  ASSERT_TRUE(buffer.at(200));
  EXPECT_EQ(buffer.at(200)->T_odom_body.matrix(), pose.matrix());
  EXPECT_TRUE(buffer.at(100));  // the ends too
  EXPECT_TRUE(buffer.at(300));
}

TEST(OdometryBuffer, InterpolationFollowsTheClosedForm) {
  OdometryBuffer buffer(kGap_us);
  buffer.add({1000, poseAt(1, 0.2)});
  buffer.add({5000, poseAt(3, 1.8)});
  for (const double s : {0.25, 0.5, 0.75}) {
    const auto pose = buffer.at(1000 + std::llround(4000 * s));
    ASSERT_TRUE(pose);
    EXPECT_TRUE(pose->T_odom_body.isApprox(poseAt(1 + 2 * s, 0.2 + 1.6 * s), 1e-12)) << s;
  }
}

// About a fixed axis in space the slerp is R_a exp(s log(R_a^T R_b)).
TEST(OdometryBuffer, RotationIsTheGeodesicAboutAnyAxis) {
  const Eigen::AngleAxisd turn(2.0, Vec3(1, -2, 0.5).normalized());
  Pose a = Pose::Identity(), b = Pose::Identity();
  a.linear() = Eigen::AngleAxisd(1.1, Vec3(0.3, 1, 2).normalized()).toRotationMatrix();
  b.linear() = a.linear() * turn.toRotationMatrix();
  for (const double s : {0.0, 0.1, 0.6, 1.0}) {
    const Mat3 expected = a.linear() * Eigen::AngleAxisd(s * turn.angle(), turn.axis()).toRotationMatrix();
    EXPECT_TRUE(interpolate(a, b, s).linear().isApprox(expected, 1e-12)) << s;
  }
}

TEST(OdometryBuffer, RotationTakesTheShorterWay) {
  const Pose middle = interpolate(poseAt(0, M_PI - 0.1), poseAt(0, -M_PI + 0.1), 0.5);
  EXPECT_TRUE(middle.isApprox(poseAt(0, M_PI), 1e-12));
}

TEST(OdometryBuffer, NothingIsExtrapolated) {
  const auto buffer = bufferOf({100, 200});
  EXPECT_FALSE(buffer.at(99));
  EXPECT_FALSE(buffer.at(201));
  EXPECT_FALSE(OdometryBuffer(kGap_us).at(0));
  EXPECT_EQ(OdometryBuffer(kGap_us).missAt(0), OdometryMiss::kAhead);
  EXPECT_EQ(buffer.missAt(201), OdometryMiss::kAhead);
  EXPECT_EQ(buffer.missAt(99), OdometryMiss::kBefore);
}

TEST(OdometryBuffer, LateAndDuplicateSamplesAreRejectedAndCounted) {
  auto buffer = bufferOf({100, 200});
  buffer.add({200, poseAt(-1, 0)});
  buffer.add({150, poseAt(-1, 0)});
  EXPECT_EQ(buffer.counts().late, 2);
  EXPECT_EQ(buffer.counts().rejected(), 2);
  EXPECT_EQ(buffer.at(200)->T_odom_body.translation().x(), 200);
  EXPECT_EQ(buffer.at(150)->T_odom_body.translation().x(), 150);
}

TEST(OdometryBuffer, LongGapsAreNotBridged) {
  const auto bridged = bufferOf({0, kGap_us});
  EXPECT_TRUE(bridged.at(1));
  auto broken = bufferOf({0, kGap_us + 1});
  broken.finish();
  EXPECT_FALSE(broken.at(1));
  EXPECT_EQ(broken.missAt(1), OdometryMiss::kGap);
  EXPECT_EQ(broken.gapAround_us(1), kGap_us + 1);
  EXPECT_TRUE(broken.at(kGap_us + 1));
}

TEST(OdometryBuffer, WhenFullTheOldestGoes) {
  OdometryBuffer buffer(kGap_us, 3);
  for (const Micros t : {1, 2, 3, 4}) {
    buffer.add({t, Pose::Identity()});
  }
  EXPECT_EQ(buffer.size(), 3u);
  EXPECT_FALSE(buffer.at(1));
  EXPECT_TRUE(buffer.at(2));
}

constexpr Micros kLong_us = 100'000'000;

TEST(OdometryBuffer, AClockThatWasSetBackBeginsAStretchOfItsOwn) {
  auto buffer = bufferOf({kLong_us, kLong_us + 1000});
  buffer.add({1000, poseAt(1, 0)});
  EXPECT_EQ(buffer.size(), 2u);  // kept apart: it may be an outlier
  buffer.add({2000, poseAt(2, 0)});
  EXPECT_EQ(buffer.size(), 2u);
  ASSERT_TRUE(buffer.at(1500));
  EXPECT_EQ(buffer.at(1500)->T_odom_body.translation().x(), 1.5);
  EXPECT_EQ(buffer.at(1500)->stretch, 1);
  EXPECT_EQ(buffer.counts().anew, 1);
  EXPECT_EQ(buffer.counts().rejected(), 0);
}

TEST(OdometryBuffer, AfterAPauseTheOdometryHasBegunAnewAndTheOldStaysKnown) {
  auto buffer = bufferOf({0, 1000, 1000 + kPause_us + 1, 2000 + kPause_us + 1});
  EXPECT_EQ(buffer.at(500)->stretch, 0);
  EXPECT_EQ(buffer.at(1500 + kPause_us)->stretch, 1);
  auto short_pause = bufferOf({0, 1000, 1000 + kPause_us, 2000 + kPause_us});
  EXPECT_EQ(short_pause.at(1500 + kPause_us)->stretch, 0);
}

TEST(OdometryBuffer, AnOutlierIsForgottenAndCounted) {
  for (const Micros off_us : {Micros{8'000'000}, Micros{3'600'000'000}, -kLong_us}) {
    auto buffer = bufferOf({kLong_us, kLong_us + 1000});
    buffer.add({kLong_us + off_us, poseAt(-7, 0)});
    buffer.add({kLong_us + 2000, poseAt(1, 0)});
    EXPECT_EQ(buffer.counts().outliers, 1);
    EXPECT_EQ(buffer.counts().anew, 0);
    EXPECT_EQ(buffer.size(), 3u);
    EXPECT_FALSE(buffer.at(kLong_us + off_us));
    EXPECT_TRUE(buffer.at(kLong_us + 1500));
  }
}

}  // namespace
}  // namespace hgg::odometry_buffer_test
