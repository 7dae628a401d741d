#include <gtest/gtest.h>

#include <cmath>

#include "eval/trajectory.h"
#include "sim/random.h"

namespace hgg::trajectory_eval_test {
namespace {

Pose pose(const Vec3& position, double angle = 0.0, const Vec3& axis = Vec3::UnitZ()) {
  Pose p = Pose::Identity();
  p.translation() = position;
  p.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  return p;
}

const Pose kGauge = pose(Vec3(3, -2, 1), 2.1, Vec3(1, 2, -1));

/// The same drive in two worlds: T_truth_body = kGauge * T_map_body.
std::vector<PosePair> pairsOf(const std::vector<Pose>& T_map_body) {
  std::vector<PosePair> pairs;
  for (const Pose& T : T_map_body) {
    pairs.push_back({kGauge * T, T});
  }
  return pairs;
}

TEST(AlignMap, RecoversTheGauge) {
  std::vector<Pose> drive;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const RandomKey key{5, i};
    drive.push_back(
        pose(10.0 * Vec3(gaussian(key, 0), gaussian(key, 1), gaussian(key, 2)), gaussian(key, 3), Vec3(1, 1, 2)));
  }
  EXPECT_TRUE(alignMap(pairsOf(drive)).isApprox(kGauge, 1e-12));
  EXPECT_NEAR(absoluteTrajectoryError(pairsOf(drive)), 0.0, 1e-9);
}

TEST(AlignMap, StraightPathKeepsItsRoll) {
  std::vector<Pose> drive;
  for (int i = 0; i < 20; ++i) {
    drive.push_back(pose(Vec3(i, 0, 0)));
  }
  EXPECT_TRUE(alignMap(pairsOf(drive)).isApprox(kGauge, 1e-12));
  EXPECT_NEAR(absoluteTrajectoryError(pairsOf(drive)), 0.0, 1e-9);
}

TEST(AlignMap, AveragesRotationErrors) {
  // Heading errors of +-0.2 rad cancel.
  std::vector<PosePair> pairs;
  for (int i = 0; i < 10; ++i) {
    const Pose T_map_body = pose(Vec3(i, 0, 0));
    Pose T_truth_body = kGauge * T_map_body;
    T_truth_body.rotate(Eigen::AngleAxisd(i % 2 == 0 ? 0.2 : -0.2, Vec3::UnitZ()));
    pairs.push_back({T_truth_body, T_map_body});
  }
  EXPECT_TRUE(alignMap(pairs).isApprox(kGauge, 1e-12));
}

TEST(TrajectoryError, EqualsAHandCheckedValue) {
  // The corners of a square, each estimated 10 % too far out: the best fit is the gauge itself and every residual is
  // 0.1 sqrt(2).
  std::vector<PosePair> square;
  for (const Vec3& corner : {Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(-1, -1, 0), Vec3(1, -1, 0)}) {
    square.push_back({kGauge * pose(corner), pose(1.1 * corner)});
  }
  EXPECT_NEAR(absoluteTrajectoryError(square), 0.1 * std::sqrt(2.0), 1e-12);
  // Two points 2 m apart, estimated 3 m apart: 0.5 m each, whatever the gauge.
  const std::vector<PosePair> two{{kGauge * pose(Vec3(1, 0, 0)), pose(Vec3(1.5, 0, 0))},
                                  {kGauge * pose(Vec3(-1, 0, 0)), pose(Vec3(-1.5, 0, 0))}};
  EXPECT_NEAR(absoluteTrajectoryError(two), 0.5, 1e-12);
}

TEST(TrajectoryError, MirroredPathIsNotFitted) {
  // A tetrahedron and its mirror image: only a reflection would give zero.
  std::vector<PosePair> pairs;
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    pairs.push_back({pose(p), pose(Vec3(p.x(), p.y(), -p.z()))});
  }
  EXPECT_GT(absoluteTrajectoryError(pairs), 0.3);
}

/// A straight drive in steps of 1 m, estimated with steps of `step` m and a turn of `yaw` each.
std::vector<PosePair> straight(int steps, double step, double yaw) {
  std::vector<PosePair> pairs{{kGauge, Pose::Identity()}};
  for (int i = 1; i <= steps; ++i) {
    pairs.push_back({kGauge * pose(Vec3(i, 0, 0)), pairs.back().T_map_body * pose(Vec3(step, 0, 0), yaw)});
  }
  return pairs;
}

TEST(RelativeError, ScaleErrorIsPerHundredMetres) {
  const RelativeError e = relativeError(straight(250, 1.01, 0));
  EXPECT_EQ(e.stretch, 100.0);
  EXPECT_EQ(e.count, 151u);
  EXPECT_NEAR(e.translation, 1.0, 1e-9);
  EXPECT_NEAR(e.rotation_deg, 0.0, 1e-6);
}

TEST(RelativeError, TurnIsPerHundredMetres) {
  const RelativeError e = relativeError(straight(250, 1.0, 0.001));
  EXPECT_NEAR(e.rotation_deg, 0.1 * 180 / M_PI, 1e-6);
  // 100 steps on a circle of radius 1 / (2 sin(yaw / 2)): the chord's end beside the point 100 m ahead. The first step
  // goes straight ahead, so the chord leaves at 99 / 2 yaw.
  const double chord = std::sin(0.05) / std::sin(0.0005), direction = 99 * 0.001 / 2;
  EXPECT_NEAR(e.translation,
              (Vec3(chord * std::cos(direction), chord * std::sin(direction), 0) - Vec3(100, 0, 0)).norm(), 1e-6);
}

TEST(RelativeError, ShortPathsAreScaledFromHalfTheirLength) {
  const RelativeError e = relativeError(straight(40, 1.02, 0));
  EXPECT_NEAR(e.stretch, 20.0, 1e-9);
  EXPECT_EQ(e.count, 21u);
  EXPECT_NEAR(e.translation, 2.0, 1e-9);
}

TEST(RelativeError, StretchEndsAtThePoseBehindItAndIsScaledByItsRealLength) {
  // Poses every 3 m: the first at least 100 m on is 102 m on.
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 80; ++i) {
    pairs.push_back({pose(Vec3(3.0 * i, 0, 0)), pose(Vec3(3.03 * i, 0, 0))});
  }
  EXPECT_NEAR(relativeError(pairs).translation, 1.0, 1e-9);
}

TEST(RelativeError, ConstantOffsetIsNone) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 300; ++i) {
    pairs.push_back({pose(Vec3(i, 0, 0)), kGauge * pose(Vec3(i, 0, 0))});
  }
  EXPECT_NEAR(relativeError(pairs).translation, 0.0, 1e-9);
  EXPECT_NEAR(relativeError(pairs).rotation_deg, 0.0, 1e-5);
}

TEST(RelativeError, StandingStillHasNone) {
  const std::vector<PosePair> pairs(5);
  EXPECT_EQ(relativeError(pairs).count, 0u);
  EXPECT_TRUE(std::isnan(relativeError(pairs).translation));
}

TEST(PairPoses, PairsByRowWhenCountsAgree) {
  const std::vector<TimedPose> estimate{{5, pose(Vec3(1, 0, 0))}, {9, pose(Vec3(2, 0, 0))}};
  const auto pairs = pairPoses(estimate, {pose(Vec3(3, 0, 0)), pose(Vec3(4, 0, 0))}, std::nullopt);
  ASSERT_TRUE(pairs) << pairs.error;
  ASSERT_EQ(pairs->size(), 2u);
  EXPECT_EQ((*pairs)[1].T_map_body.translation().x(), 2.0);
  EXPECT_EQ((*pairs)[1].T_truth_body.translation().x(), 4.0);
}

TEST(PairPoses, PairsByNearestTimeWithinFiveMilliseconds) {
  const std::vector<TimedPose> estimate{{100'000, pose(Vec3(1, 0, 0))},
                                        {205'000, pose(Vec3(2, 0, 0))},
                                        {305'001, pose(Vec3(3, 0, 0))},
                                        {399'000, pose(Vec3(4, 0, 0))}};
  const std::vector<Pose> truth{pose(Vec3(10, 0, 0)), pose(Vec3(20, 0, 0)), pose(Vec3(30, 0, 0)), pose(Vec3(40, 0, 0)),
                                pose(Vec3(50, 0, 0))};
  const auto pairs = pairPoses(estimate, truth, std::vector<Micros>{100'000, 200'000, 300'000, 400'000, 500'000});
  ASSERT_TRUE(pairs) << pairs.error;
  ASSERT_EQ(pairs->size(), 3u);
  EXPECT_EQ((*pairs)[1].T_map_body.translation().x(), 2.0);
  EXPECT_EQ((*pairs)[2].T_map_body.translation().x(), 4.0);
  EXPECT_EQ((*pairs)[2].T_truth_body.translation().x(), 40.0);
}

TEST(PairPoses, UnlikeCountsNeedTimes) {
  const std::vector<TimedPose> estimate(3);
  const auto pairs = pairPoses(estimate, std::vector<Pose>(4, Pose::Identity()), std::nullopt);
  ASSERT_FALSE(pairs);
  EXPECT_NE(pairs.error.find("3 estimated and 4 true"), std::string::npos) << pairs.error;
  EXPECT_NE(pairs.error.find("--times"), std::string::npos) << pairs.error;
}

TEST(PairPoses, TimesMustBelongToThePoses) {
  const std::vector<TimedPose> estimate(3);
  const std::vector<Pose> truth(3, Pose::Identity());
  EXPECT_FALSE(pairPoses(estimate, truth, std::vector<Micros>{1, 2}));
  EXPECT_FALSE(pairPoses(estimate, truth, std::vector<Micros>{100'000, 200'000, 300'000}));
}

}  // namespace
}  // namespace hgg::trajectory_eval_test
