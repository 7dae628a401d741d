#include "sim/kidnap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bus/codec.h"
#include "bus/log.h"
#include "sim/simulate.h"
#include "tools/scratch.h"

namespace hgg::kidnap_test {
namespace {

constexpr double kRate_hz = 10.0;
const Progress kQuiet = [](std::size_t, std::size_t) {};

/// A tour of 40 s along x at 1 m/s, nothing around it.
Scene corridor() {
  Scene scene;
  scene.T_world_body = [](double time) { return Pose(Eigen::Translation3d(time, 0.5, 0)); };
  scene.duration = 40.0;
  return scene;
}

SimOptions smallDrive() {
  SimOptions options;
  options.rate_hz = 2.0;
  options.sensors.lidar = spinningLidar(16, false);
  options.sensors.lidar->columns = 36;
  options.odometry = OdometryErrors{};
  return options;
}

struct Logged {
  std::vector<double> odometry_s, clouds_s;
  std::vector<Pose> odometry;
};

Logged readLog(const std::filesystem::path& path) {
  Logged logged;
  auto reader = LogReader::open(path.string());
  EXPECT_TRUE(reader) << reader.error;
  while (const auto event = reader->next()) {
    const double time = static_cast<double>(event->timestamp_us) * 1e-6 - 1.0;
    if (event->channel == "POSE_ODOM") {
      logged.odometry_s.push_back(time);
      logged.odometry.push_back(decodePose(event->data)->T_odom_body);
    } else if (event->channel == "LIDAR_SEMANTIC") {
      logged.clouds_s.push_back(time);
    }
  }
  return logged;
}

TEST(Kidnap, TheTourGoesOnFromTheOtherPlace) {
  const auto scene = kidnapped(corridor(), {20.0, 12.0, std::nullopt}, kRate_hz, 1);
  ASSERT_TRUE(scene) << scene.error;
  EXPECT_NEAR(scene->T_world_body(20.0).translation().x(), 20.0, 1e-9);
  const double put_down = 20.0 + kCarrySeconds, place = scene->T_world_body(put_down).translation().x();
  EXPECT_NEAR(place, 8.0, 0.5);
  EXPECT_NEAR(scene->T_world_body(put_down + 3).translation().x(), place + 3.0, 1e-9);
  EXPECT_NEAR(scene->T_world_body(put_down - 0.1).translation().x(), place - 0.1, 1e-9);  // a sweep begins before it
  EXPECT_NEAR(scene->T_world_body(scene->duration).translation().x(), 40.0, 1e-9);
}

TEST(Kidnap, AFrameOfTheTourMayBeAhead) {
  const auto scene = kidnapped(corridor(), {20.0, std::nullopt, 300}, kRate_hz, 1);
  ASSERT_TRUE(scene) << scene.error;
  EXPECT_NEAR(scene->T_world_body(20.0 + kCarrySeconds).translation().x(), 30.0, 1e-9);
  EXPECT_FALSE(kidnapped(corridor(), {20.0, std::nullopt, 401}, kRate_hz, 1));
}

TEST(Kidnap, WithoutADistanceThePlaceIsFiveToSixtyMetresAwayAndBySeed) {
  double nearest = 1e9, farthest = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto scene = kidnapped(corridor(), {30.0, std::nullopt, std::nullopt}, kRate_hz, seed);
    const double away = 30.0 - scene->T_world_body(30.0 + kCarrySeconds).translation().x();
    nearest = std::min(nearest, away), farthest = std::max(farthest, away);
  }
  EXPECT_GE(nearest, 5.0 - 1e-9);
  EXPECT_LE(farthest, 30.0 + 1e-9);
  EXPECT_GT(farthest - nearest, 10.0);
}

TEST(Kidnap, APlaceThatWasNotSeenIsAnErrorThatSaysHowFarItGoes) {
  const auto scene = kidnapped(corridor(), {20.0, 25.0, std::nullopt}, kRate_hz, 1);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error.find("20 m"), std::string::npos) << scene.error;
  EXPECT_FALSE(kidnapped(corridor(), {40.0, 5.0, std::nullopt}, kRate_hz, 1));
}

TEST(Kidnap, NothingIsSensedOnTheWayAndTheTruthJumps) {
  const Scratch scratch;
  const auto scene = kidnapped(makeYard(1), {10.0, std::nullopt, 4}, 2.0, 1);
  ASSERT_TRUE(scene) << scene.error;
  SimOptions options = smallDrive();
  options.frames = 36;
  const auto drive = simulate(*scene, options, scratch / "log", kQuiet);
  ASSERT_TRUE(drive) << drive.error;
  const Logged logged = readLog(scratch / "log");
  EXPECT_EQ(logged.clouds_s, logged.odometry_s);
  EXPECT_EQ(logged.clouds_s.size(), drive->T_map_body.size());
  EXPECT_EQ(logged.clouds_s[20], 10.0);
  EXPECT_EQ(logged.clouds_s[21], 13.0);
  EXPECT_TRUE(drive->T_map_body[21].isApprox(drive->T_map_body[4], 1e-9));
  EXPECT_TRUE(logged.odometry[21].isApprox(logged.odometry[20], 1e-9));  // odometry felt nothing
  EXPECT_TRUE((logged.odometry[21].inverse() * logged.odometry[25])
                  .isApprox(drive->T_map_body[4].inverse() * drive->T_map_body[8], 1e-9));
}

TEST(Kidnap, OdometryMayRestartAtZeroOrKnowTheWay) {
  const Scratch scratch;
  const auto scene = kidnapped(makeYard(1), {10.0, std::nullopt, 4}, 2.0, 1);
  SimOptions options = smallDrive();
  options.frames = 36;
  options.carried_odometry = CarriedOdometry::kRestarts;
  ASSERT_TRUE(simulate(*scene, options, scratch / "zero", kQuiet));
  const Logged zero = readLog(scratch / "zero");
  EXPECT_FALSE(zero.odometry[20].isApprox(Pose::Identity(), 1e-3));
  EXPECT_TRUE(zero.odometry[21].isApprox(Pose::Identity(), 1e-9));
  options.carried_odometry = CarriedOdometry::kFollows;
  const auto drive = simulate(*scene, options, scratch / "true", kQuiet);
  const Logged follows = readLog(scratch / "true");
  for (std::size_t i = 0; i < follows.odometry.size(); ++i) {
    EXPECT_TRUE(follows.odometry[i].isApprox(drive->T_map_body[i], 1e-9)) << i;
  }
}

TEST(Kidnap, WhatCannotBeReadIsAnError) {
  for (const char* text : {"", "x", ":5", "20:", "20:x", "-1:5", "20:-5", "20@1.5", "20@", "20:5:5"}) {
    EXPECT_FALSE(parseKidnap(text)) << text;
  }
  const auto at = parseKidnap("20.5:12"), frame = parseKidnap("20@7"), anywhere = parseKidnap("20");
  ASSERT_TRUE(at && frame && anywhere);
  EXPECT_EQ(at->time, 20.5);
  EXPECT_EQ(at->metres, 12.0);
  EXPECT_EQ(frame->frame, 7);
  EXPECT_FALSE(anywhere->metres || anywhere->frame);
}

}  // namespace
}  // namespace hgg::kidnap_test
