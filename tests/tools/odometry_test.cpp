#include "sim/odometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hgg::odometry_test {
namespace {

std::vector<Pose> straight(std::size_t steps, double step = 1.0) {
  std::vector<Pose> poses(steps + 1, Pose::Identity());
  for (std::size_t i = 0; i <= steps; ++i) {
    poses[i].translation().x() = step * static_cast<double>(i);
  }
  return poses;
}

/// 400 m around a block, twice, with 0.5 m steps.
std::vector<Pose> laps() {
  std::vector<Pose> poses{Pose::Identity()};
  for (int i = 0; i < 800; ++i) {
    const bool is_corner = i % 100 >= 95;
    Pose step = Pose::Identity();
    step.translation().x() = 0.5;
    step.linear() = Eigen::AngleAxisd(is_corner ? M_PI / 10 : 0.0, Vec3::UnitZ()).toRotationMatrix();
    poses.push_back(poses.back() * step);
  }
  return poses;
}

/// Mean translation error of all stretches of 100 m (steps of 0.5 m), in percent.
double driftPercent(const std::vector<Pose>& truth, const std::vector<Pose>& odometry) {
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i + 200 < truth.size(); i += 10, ++n) {
    const Pose error = (truth[i].inverse() * truth[i + 200]).inverse() * (odometry[i].inverse() * odometry[i + 200]);
    sum += error.translation().norm();
  }
  return sum / n;
}

double meanDrift(const std::string& preset) {
  const auto truth = laps();
  double sum = 0;
  constexpr int kSeeds = 40;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    sum += driftPercent(truth, disturbOdometry(truth, *odometryPreset(preset), seed));
  }
  return sum / kSeeds;
}

TEST(Odometry, TrueOdometryIsTheTruth) {
  const auto truth = laps();
  const auto odometry = disturbOdometry(truth, *odometryPreset("true"), 1);
  ASSERT_EQ(odometry.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_TRUE(odometry[i].isApprox(truth[i], 1e-9));
  }
}

TEST(Odometry, PresetsDriftAsPromised) {
  const double excellent = meanDrift("excellent"), good = meanDrift("good"), poor = meanDrift("poor");
  RecordProperty("excellent", std::to_string(excellent));
  RecordProperty("good", std::to_string(good));
  RecordProperty("poor", std::to_string(poor));
  EXPECT_GT(excellent, 0.1);
  EXPECT_LT(excellent, 0.2);
  EXPECT_GT(good, 0.5);
  EXPECT_LT(good, 1.0);
  EXPECT_GT(poor, 2.0);
  EXPECT_LT(poor, 6.0);
}

TEST(Odometry, EveryPresetThatIsNamedIsKnown) {
  EXPECT_EQ(odometryPresetNames().size(), 5u);
  for (const std::string& name : odometryPresetNames()) {
    EXPECT_TRUE(odometryPreset(name)) << name;
  }
  EXPECT_FALSE(odometryPreset("superb"));
}

TEST(Odometry, BiasIsOfItsSizeAndOfEitherSign) {
  const auto truth = straight(100);
  double scale = 0, yaw_deg = 0;
  int longer = 0, left = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double far = disturbOdometry(truth, {.scale = 0.01}, seed).back().translation().x() - 100.0;
    const auto turned = disturbOdometry(truth, {.yaw_deg_per_m = 0.05}, seed).back();
    const double angle_deg = std::atan2(turned.linear()(1, 0), turned.linear()(0, 0)) * 180 / M_PI;
    scale += std::abs(far) / 100, yaw_deg += std::abs(angle_deg);
    longer += far > 0, left += angle_deg > 0;
  }
  EXPECT_NEAR(scale / kSeeds, 0.01, 0.001);
  EXPECT_NEAR(yaw_deg / kSeeds, 5.0, 0.5);
  EXPECT_NEAR(longer, kSeeds / 2, 30);
  EXPECT_NEAR(left, kSeeds / 2, 30);
}

TEST(Odometry, BiasWandersSlowly) {
  const auto truth = straight(400);
  const auto odometry = disturbOdometry(truth, {.scale = 0.01}, 5);
  const auto scaleOver = [&](std::size_t a, std::size_t b) {
    return (odometry[b].translation().x() - odometry[a].translation().x()) / static_cast<double>(b - a) - 1.0;
  };
  EXPECT_NEAR(scaleOver(0, 10), scaleOver(10, 20), 0.002);
  EXPECT_GT(std::abs(scaleOver(0, 100) - scaleOver(300, 400)), 1e-5);
}

TEST(Odometry, NoiseGrowsWithTheRootOfTheWayWhateverTheRate) {
  for (const double step : {0.1, 1.0}) {
    const auto truth = straight(static_cast<std::size_t>(std::lround(100 / step)), step);
    double squares = 0;
    constexpr int kSeeds = 400;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      squares += std::pow(disturbOdometry(truth, {.noise = 0.02}, seed).back().translation().y(), 2);
    }
    EXPECT_NEAR(std::sqrt(squares / kSeeds), 0.2, 0.03) << step;
  }
}

TEST(Odometry, JumpsComeAtTheirRate) {
  const auto truth = straight(20000, 0.5);
  const auto odometry = disturbOdometry(truth, {.jumps_per_100m = 2.0, .jump_yaw_deg = 0.0}, 1);
  int jumps = 0;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    jumps += ((odometry[i].translation() - odometry[i - 1].translation()).norm() - 0.5) > 1e-6 ||
             std::abs(odometry[i].translation().y() - odometry[i - 1].translation().y()) > 1e-6;
  }
  EXPECT_NEAR(jumps, 200, 4 * std::sqrt(200.0));
}

TEST(Odometry, MissingSamplesComeAtTheirRateButNeverFirstOrLast) {
  int missing = 0;
  for (std::size_t i = 0; i < 5000; ++i) {
    missing += isOdometryMissing({.dropout = 0.1}, 3, i, 5000);
  }
  EXPECT_NEAR(missing, 500, 4 * std::sqrt(450.0));
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_FALSE(isOdometryMissing({.dropout = 1.0}, seed, 0, 10));
    EXPECT_FALSE(isOdometryMissing({.dropout = 1.0}, seed, 9, 10));
    EXPECT_TRUE(isOdometryMissing({.dropout = 1.0}, seed, 5, 10));
  }
}

TEST(Odometry, SeedsDifferAndRepeat) {
  const auto truth = laps();
  const auto good = *odometryPreset("good");
  EXPECT_EQ(disturbOdometry(truth, good, 1).back().matrix(), disturbOdometry(truth, good, 1).back().matrix());
  EXPECT_NE(disturbOdometry(truth, good, 1).back().matrix(), disturbOdometry(truth, good, 2).back().matrix());
}

}  // namespace
}  // namespace hgg::odometry_test
