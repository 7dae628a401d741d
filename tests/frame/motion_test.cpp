#include "frame/motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.h"

namespace hgg::motion_test {
namespace {

constexpr Micros kStart_us = 10'000'000;

/// Turns at 90 degrees a second and drives an arc at 2 m/s.
Pose truth(double t) {
  const double w = 90 * kDegree, v = 2, a = w * t;
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(a, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = v / w * Vec3(std::sin(a), 1 - std::cos(a), 0);
  return T;
}

Micros stamp(double t) { return kStart_us + std::llround(t * 1e6); }

OdometryBuffer odometry(double rate_hz, double until, double delay = 0) {
  OdometryBuffer buffer(3'000'000);
  for (int k = 0; k <= std::lround(until * rate_hz); ++k) {
    buffer.add({stamp(k / rate_hz + delay), truth(k / rate_hz)});
  }
  return buffer;
}

/// What a spinning sensor sees of posts around it during the sweep of 0.1 s before `t`, each from the body of its
/// moment.
struct Scan {
  std::vector<Point> seen;
  std::vector<float> times;
  std::vector<Vec3> p_body;  // where the posts are from the body at t
};

Scan sweep(double t) {
  Scan scan;
  for (int k = 0; k < 360; ++k) {
    const double at = t - 0.1 + 0.1 * k / 359, angle = k * kDegree;
    const Vec3 p_world = truth(t) * Vec3(30 * std::cos(angle), 30 * std::sin(angle), 1);
    const Eigen::Vector3f p = (truth(at).inverse() * p_world).cast<float>();
    scan.seen.push_back({p.x(), p.y(), p.z(), 0, 0});
    scan.times.push_back(static_cast<float>(at - t));
    scan.p_body.emplace_back(truth(t).inverse() * p_world);
  }
  return scan;
}

double worst(const std::vector<Point>& points, const std::vector<Vec3>& truth) {
  double most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    most = std::max(most, (Vec3(points[i].x, points[i].y, points[i].z) - truth[i]).norm());
  }
  return most;
}

TEST(Motion, ADeskewedCloudIsTheUndistortedOne) {
  const Scan scan = sweep(1);
  Frame frame;
  frame.utime_us = stamp(1);
  frame.points = scan.seen;
  frame.times = scan.times;
  EXPECT_GT(worst(frame.points, scan.p_body), 4);  // 9 degrees at 30 m
  ASSERT_TRUE(deskew(frame, odometry(100, 1), 0));
  EXPECT_LT(worst(frame.points, scan.p_body), 0.005);
  EXPECT_TRUE(frame.times.empty());
}

TEST(Motion, OdometryAsRareAsCloudsIsEnough) {
  const Scan scan = sweep(1);
  Frame frame;
  frame.utime_us = stamp(1);
  frame.points = scan.seen;
  frame.times = scan.times;
  ASSERT_TRUE(deskew(frame, odometry(10, 1), 0));
  EXPECT_LT(worst(frame.points, scan.p_body), 0.02);  // the arc is taken for its chord
}

TEST(Motion, TheDelayOfOdometryIsUndone) {
  const Scan scan = sweep(1);
  std::vector<Point> points = scan.seen;
  ASSERT_TRUE(movePoints(points, scan.times, stamp(1), stamp(1), odometry(100, 2, 0.2), 200'000));
  EXPECT_LT(worst(points, scan.p_body), 0.005);
}

TEST(Motion, TakesACloudToAnotherTime) {
  const Scan scan = sweep(1);
  std::vector<Point> points = scan.seen;
  ASSERT_TRUE(movePoints(points, scan.times, stamp(1), stamp(1.05), odometry(100, 2), 0));
  std::vector<Vec3> expected;
  for (const Vec3& p : scan.p_body) {
    expected.emplace_back(truth(1.05).inverse() * truth(1) * p);
  }
  EXPECT_LT(worst(points, expected), 0.005);
}

TEST(Motion, GoesOnALittleBeyondOdometry) {
  const auto T = motionBetween(odometry(100, 1), stamp(0.9), stamp(1.1), 0);
  ASSERT_TRUE(T);
  EXPECT_LT((T->matrix() - (truth(1.1).inverse() * truth(0.9)).matrix()).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_FALSE(motionBetween(odometry(100, 1), stamp(0.9), stamp(1.5), 0));
}

TEST(Motion, WithoutOdometryNothingIsMoved) {
  const Scan scan = sweep(1);
  std::vector<Point> points = scan.seen;
  EXPECT_FALSE(movePoints(points, scan.times, stamp(1), stamp(1), OdometryBuffer(3'000'000), 0));
  EXPECT_EQ(points[7].x, scan.seen[7].x);
}

TEST(Motion, NothingIsMovedAcrossABeginningAnew) {
  OdometryBuffer buffer = odometry(100, 1);
  for (int k = 0; k < 100; ++k) {
    buffer.add({stamp(100 + k * 0.01), truth(k * 0.01)});  // after a pause
  }
  EXPECT_FALSE(motionBetween(buffer, stamp(0.9), stamp(100.5), 0));
  EXPECT_TRUE(motionBetween(buffer, stamp(100.4), stamp(100.5), 0));
}

TEST(Motion, TimesThatMakeNoSenseCountAsTheClouds) {
  std::vector<Point> points = {{1, 2, 3, 0, 0}, {1, 2, 3, 0, 0}};
  const std::vector<float> times = {NAN, 1.7e9F};
  ASSERT_TRUE(movePoints(points, times, stamp(0.5), stamp(0.5), odometry(100, 1), 0));
  EXPECT_NEAR(points[0].x, 1, 1e-5);
  EXPECT_NEAR(points[1].y, 2, 1e-5);
}

}  // namespace
}  // namespace hgg::motion_test
