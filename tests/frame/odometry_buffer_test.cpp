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

OdometryBuffer bufferOf(std::initializer_list<Micros> times_us) {
  OdometryBuffer buffer;
  for (const Micros t : times_us) {
    buffer.add({t, poseAt(static_cast<double>(t), 0)});
  }
  return buffer;
}

TEST(OdometryBuffer, ExactHitIsReturnedBitForBit) {
  OdometryBuffer buffer;
  const Pose pose = poseAt(0.1, 0.3);
  buffer.add({100, poseAt(0, 0)});
  buffer.add({200, pose});
  buffer.add({300, poseAt(1, 1)});
  ASSERT_TRUE(buffer.at(200));
  EXPECT_EQ(buffer.at(200)->matrix(), pose.matrix());
  EXPECT_TRUE(buffer.at(100));  // the ends too
  EXPECT_TRUE(buffer.at(300));
}

TEST(OdometryBuffer, InterpolationFollowsTheClosedForm) {
  OdometryBuffer buffer;
  buffer.add({1000, poseAt(1, 0.2)});
  buffer.add({5000, poseAt(3, 1.8)});
  for (const double s : {0.25, 0.5, 0.75}) {
    const auto pose = buffer.at(1000 + std::llround(4000 * s));
    ASSERT_TRUE(pose);
    EXPECT_TRUE(pose->isApprox(poseAt(1 + 2 * s, 0.2 + 1.6 * s), 1e-12)) << s;
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
  EXPECT_FALSE(OdometryBuffer().at(0));
  EXPECT_TRUE(buffer.isAhead(201));
  EXPECT_FALSE(buffer.isAhead(200));
  EXPECT_FALSE(buffer.isAhead(99));
}

TEST(OdometryBuffer, LateAndDuplicateSamplesAreRejectedAndCounted) {
  auto buffer = bufferOf({100, 200});
  EXPECT_FALSE(buffer.add({200, poseAt(-1, 0)}));
  EXPECT_FALSE(buffer.add({150, poseAt(-1, 0)}));
  EXPECT_EQ(buffer.rejected(), 2);
  EXPECT_EQ(buffer.at(200)->translation().x(), 200);
  EXPECT_EQ(buffer.at(150)->translation().x(), 150);
}

TEST(OdometryBuffer, LongGapsAreNotBridged) {
  const auto bridged = bufferOf({0, kMaxOdometryGap_us});
  EXPECT_TRUE(bridged.at(1));
  const auto broken = bufferOf({0, kMaxOdometryGap_us + 1});
  EXPECT_FALSE(broken.at(1));
  EXPECT_TRUE(broken.at(kMaxOdometryGap_us + 1));
}

TEST(OdometryBuffer, WhenFullTheOldestGoes) {
  OdometryBuffer buffer(3);
  for (const Micros t : {1, 2, 3, 4}) {
    buffer.add({t, Pose::Identity()});
  }
  EXPECT_EQ(buffer.size(), 3u);
  EXPECT_FALSE(buffer.at(1));
  EXPECT_TRUE(buffer.at(2));
}

TEST(OdometryBuffer, ARestartBeginsAnew) {
  auto buffer = bufferOf({kRestart_us + 500, kRestart_us + 1000});
  EXPECT_FALSE(buffer.add({1000, Pose::Identity()}));  // back by just the bound: late
  EXPECT_TRUE(buffer.add({999, Pose::Identity()}));
  EXPECT_EQ(buffer.size(), 1u);
  EXPECT_TRUE(buffer.at(999));
  EXPECT_TRUE(buffer.add({1001, Pose::Identity()}));
}

}  // namespace
}  // namespace hgg::odometry_buffer_test
