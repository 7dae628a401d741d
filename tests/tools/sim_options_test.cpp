#include <gtest/gtest.h>

#include "sim/options.h"
#include "tools/scratch.h"
#include "truth/poses.h"

namespace hgg::sim_options_test {
namespace {

SimArguments yard() {
  SimArguments arguments;
  arguments.world = "yard";
  return arguments;
}

SimOptions optionsOf(const SimArguments& arguments) {
  const auto options = simOptions(arguments, makeYard(1));
  EXPECT_TRUE(options) << options.error;
  return *options;
}

TEST(SimOptions, EverySensorThatIsListedIsMade) {
  for (const SensorName& sensor : sensorNames()) {
    SimArguments arguments = yard();
    arguments.sensor = sensor.name;
    const SensorSuite suite = optionsOf(arguments).sensors;
    EXPECT_TRUE(suite.lidar || !suite.cameras.empty()) << sensor.name;
    EXPECT_EQ(suite.cameras.size(), sensor.name == "rig" ? 3u : sensor.name == "rgbd" ? 1u : 0u);
    EXPECT_TRUE(!sensor.name.starts_with("lidar") || suite.lidar->beams == std::stoi(sensor.name.substr(5)));
  }
}

TEST(SimOptions, IndoorsALidarLooksUpAndNear) {
  Scene indoor = makeYard(1);
  indoor.label_space = "indoor";
  const auto options = simOptions(yard(), indoor);
  EXPECT_GT(options->sensors.lidar->elevation_max_deg, 20.0);
  EXPECT_LT(options->sensors.lidar->errors.range_min, optionsOf(yard()).sensors.lidar->errors.range_min);
}

TEST(SimOptions, TheNoiseHasASeedOfItsOwn) {
  SimArguments arguments = yard();
  arguments.options.seed = 7;
  EXPECT_EQ(optionsOf(arguments).seed, 7U);
  arguments.noise_seed = 9;
  EXPECT_EQ(optionsOf(arguments).seed, 9U);
  EXPECT_EQ(arguments.options.seed, 7U);  // the world's
}

TEST(SimOptions, ARateOverridesItsPresetAlone) {
  SimArguments arguments = yard();
  arguments.labels = "poor";
  arguments.missed = 0.0;
  arguments.dropout = 0.3;
  const SimOptions options = optionsOf(arguments);
  EXPECT_EQ(options.cloud_labels.missed, 0.0);
  EXPECT_EQ(options.image_labels.missed, 0.0);
  EXPECT_EQ(options.cloud_labels.confused, labelPreset("poor", Segmented::kCloud)->confused);
  EXPECT_EQ(options.sensors.lidar->errors.dropout, 0.3);
}

TEST(SimOptions, CommonConfusionIsBesideThatOfThePreset) {
  SimArguments arguments = yard();
  EXPECT_EQ(optionsOf(arguments).cloud_labels.common, 0.0);
  arguments.confusion_common = 0.1;
  const SimOptions options = optionsOf(arguments);
  EXPECT_EQ(options.cloud_labels.common, 0.1);
  EXPECT_EQ(options.image_labels.common, 0.1);
  EXPECT_EQ(options.cloud_labels.confused, labelPreset("good", Segmented::kCloud)->confused);
}

TEST(SimOptions, PlatesAreForWorldsThatCanHaveThem) {
  SimArguments arguments = yard();
  arguments.plates = true;
  EXPECT_FALSE(simOptions(arguments, makeYard(1)));
  arguments.world = "street";
  EXPECT_TRUE(simOptions(arguments, makeYard(1)));
}

TEST(SimOptions, ARateOnPerfectLabelsHasAnExtent) {
  SimArguments arguments = yard();
  arguments.labels = "perfect";
  arguments.bleed = 0.2, arguments.confusion = 0.1;
  const LabelErrors errors = optionsOf(arguments).cloud_labels;
  EXPECT_EQ(errors.bleed, 0.2);
  EXPECT_GT(errors.bleed_deg, 0.0);
  EXPECT_GT(errors.stretch_frames, 1);
  EXPECT_EQ(errors.speckle, 0.0);
}

TEST(SimOptions, APathsOwnOdometryIsTakenUnlessAPresetIsGiven) {
  const Scratch scratch;
  std::vector<Pose> poses(30, Pose::Identity());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].translation().z() = static_cast<double>(i);  // camera: forward
  }
  ASSERT_EQ(writePoses(poses, scratch / "gt.txt"), "");
  SimArguments arguments;
  arguments.path = {(scratch / "gt.txt").string(), (scratch / "gt.txt").string()};
  const auto scene = sceneOf(arguments);
  ASSERT_TRUE(scene) << scene.error;
  EXPECT_FALSE(simOptions(arguments, *scene)->odometry);
  arguments.odometry_jumps = 1.0;
  EXPECT_NE(simOptions(arguments, *scene).error.find("--odometry"), std::string::npos);
  arguments.odometry = "poor";
  EXPECT_EQ(simOptions(arguments, *scene)->odometry->scale, odometryPreset("poor")->scale);
  EXPECT_EQ(simOptions(arguments, *scene)->odometry->jumps_per_100m, 1.0);
}

TEST(SimOptions, WhatWouldDoNothingIsRefused) {
  const auto errorOf = [](const std::string& sensor, auto change) {
    SimArguments arguments = yard();
    arguments.sensor = sensor;
    change(arguments);
    return simOptions(arguments, makeYard(1)).error;
  };
  const auto cameras = [](SimArguments& arguments) { arguments.cameras = 2; };
  const auto no_semantic = [](SimArguments& arguments) { arguments.options.semantic_cloud = false; };
  const auto distortion = [](SimArguments& arguments) { arguments.options.motion_distortion = true; };
  for (const char* sensor : {"lidar16", "rgbd", "rig"}) {
    const bool is_rig = std::string(sensor) == "rig", is_rgbd = std::string(sensor) == "rgbd";
    EXPECT_EQ(errorOf(sensor, cameras).starts_with("--cameras"), !is_rig) << sensor;
    EXPECT_EQ(errorOf(sensor, no_semantic).starts_with("--no-semantic"), !is_rig && !is_rgbd) << sensor;
    EXPECT_EQ(errorOf(sensor, distortion).starts_with("--motion-distortion"), is_rgbd) << sensor;
  }
}

TEST(SimOptions, FaultsAreReadAndRefusedWhereTheyWouldDoNothing) {
  SimArguments arguments = yard();
  arguments.odometry_faults = {"slip:1.2@3", "xyzw"};
  const OdometryFaults faults = optionsOf(arguments).odometry_faults;
  EXPECT_TRUE(faults.quaternion_xyzw);
  ASSERT_EQ(faults.timed.size(), 1u);
  EXPECT_EQ(faults.timed[0].kind, FaultKind::kSlip);
  arguments.options.frames = 20;  // 2 s
  EXPECT_NE(simOptions(arguments, makeYard(1)).error.find("slip:1.2@3"), std::string::npos);
  arguments.odometry_faults = {"leap@1"};
  EXPECT_NE(simOptions(arguments, makeYard(1)).error.find("--odometry-fault leap@1"), std::string::npos);
  arguments.odometry_faults.clear();
  arguments.options.odometry_faults.bursts_stay = true;
  EXPECT_NE(simOptions(arguments, makeYard(1)).error.find("--odometry-bursts"), std::string::npos);
  arguments.options.odometry_faults.bursts_stay = false;
  arguments.kidnap_odometry = "zero";
  EXPECT_NE(simOptions(arguments, makeYard(1)).error.find("--kidnap"), std::string::npos);
}

TEST(SimOptions, AKidnappedDriveLastsUntilItsTourEnds) {
  SimArguments arguments = yard();
  arguments.kidnap = "10@40";
  arguments.kidnap_odometry = "zero";
  const auto scene = sceneOf(arguments);
  ASSERT_TRUE(scene) << scene.error;
  EXPECT_NEAR(scene->duration, makeYard(1).duration + 10.0 + kCarrySeconds - 4.0, 1e-9);
  EXPECT_EQ(simOptions(arguments, *scene)->carried_odometry, CarriedOdometry::kRestarts);
  arguments.options.frames = 120;
  EXPECT_NE(simOptions(arguments, *scene).error.find("put down"), std::string::npos);
  arguments.kidnap = "10@x";
  EXPECT_NE(sceneOf(arguments).error.find("SECONDS"), std::string::npos);
}

TEST(SimOptions, APathHasAsManyFramesAsPoses) {
  const Scratch scratch;
  std::vector<Pose> poses(30, Pose::Identity());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].translation().z() = static_cast<double>(i);
  }
  ASSERT_EQ(writePoses(poses, scratch / "gt.txt"), "");
  SimArguments arguments;
  arguments.path = {(scratch / "gt.txt").string(), (scratch / "gt.txt").string()};
  const auto scene = sceneOf(arguments);
  ASSERT_TRUE(scene) << scene.error;
  arguments.options.frames = 30;
  EXPECT_TRUE(simOptions(arguments, *scene));
  arguments.options.frames = 31;
  EXPECT_NE(simOptions(arguments, *scene).error.find(" 30"), std::string::npos);
  arguments.options.rate_hz = 5.0;
  arguments.options.frames = 16;
  EXPECT_NE(simOptions(arguments, *scene).error.find(" 15"), std::string::npos);
}

TEST(SimOptions, PathsThatDoNotMatchAreAnError) {
  const Scratch scratch;
  ASSERT_EQ(writePoses(std::vector<Pose>(3, Pose::Identity()), scratch / "gt.txt"), "");
  ASSERT_EQ(writePoses(std::vector<Pose>(2, Pose::Identity()), scratch / "odometry.txt"), "");
  SimArguments arguments;
  arguments.path = {(scratch / "gt.txt").string(), (scratch / "odometry.txt").string()};
  EXPECT_NE(sceneOf(arguments).error.find("same number of poses"), std::string::npos);
  arguments.path[1] = (scratch / "missing.txt").string();
  EXPECT_NE(sceneOf(arguments).error.find("missing.txt"), std::string::npos);
}

TEST(SimOptions, UnknownNamesAreErrorsThatSayWhereTheNamesAre) {
  SimArguments arguments = yard();
  arguments.world = "atlantis";
  EXPECT_NE(sceneOf(arguments).error.find("--list"), std::string::npos);
  arguments = yard();
  arguments.sensor = "sonar";
  EXPECT_NE(simOptions(arguments, makeYard(1)).error.find("--list"), std::string::npos);
  arguments = yard();
  arguments.labels = "excellent";
  EXPECT_FALSE(simOptions(arguments, makeYard(1)));
  arguments = yard();
  arguments.odometry = "superb";
  EXPECT_FALSE(simOptions(arguments, makeYard(1)));
}

}  // namespace
}  // namespace hgg::sim_options_test
