#include "rig_input.h"

#include <gtest/gtest.h>

#include "pipeline.h"

namespace hgg::rig_input_test {
namespace {

constexpr Micros kStart_us = 10'000'000, kPeriod_us = 100'000;
constexpr int kFrames = 5;

/// A wall 6 m ahead.
std::vector<Point> wall() {
  std::vector<Point> points;
  for (float y = -3; y < 3; y += 0.1F) {
    for (float z = -1; z < 1; z += 0.1F) {
      points.push_back({6, y, z, 0, 0});
    }
  }
  return points;
}

LabelImage labels(const RigCamera& camera, Micros utime_us, ClassId label) {
  LabelImage image;
  image.utime_us = utime_us;
  image.width = camera.model.width, image.height = camera.model.height;
  image.labels.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), label);
  return image;
}

std::vector<std::uint8_t> mainMessage(const CloudSource& source, Micros utime_us) {
  if (source.lidar != nullptr) {
    return encodeCloud(utime_us, wall());
  }
  const CameraModel& m = source.camera->model;
  const auto pixels = static_cast<std::size_t>(m.width) * static_cast<std::size_t>(m.height);
  return encodeDepthImage({utime_us, m.width, m.height, std::vector<std::uint16_t>(pixels, 4000)});
}

/// A robot as shipped, and what its sensors send.
struct Started {
  LoadedConfig loaded;
  Rig rig;
  RunCounts counts;
  std::int64_t frames = 0;
};

Started start(const std::string& robot, ClassId label, const std::string& without = "") {
  auto loaded = loadConfig(std::string(HGG_SOURCE_DIR "/firmware_cfg/") + robot + "/hggmap.toml");
  EXPECT_TRUE(loaded) << loaded.error;
  auto rig = takeRig(*loaded);
  EXPECT_TRUE(rig && *rig) << rig.error;
  Mapper mapper(loaded->config, loaded->classes);
  Pipeline pipeline(mapper, {}, OdometryWait::kUnlimited, *rig);
  const auto sources = cloudSources(**rig);
  for (int k = 0; k < kFrames; ++k) {
    const Micros t = kStart_us + k * kPeriod_us;
    pipeline.addOdometry(encodePose(t, Pose::Identity()), t);
    pipeline.addCloud(mainMessage(sources.front(), t), t);
    for (const RigCamera& camera : (*rig)->cameras) {
      if (camera.labels != without) {
        EXPECT_TRUE(pipeline.isRigChannel(camera.labels));
        pipeline.addRigMessage(camera.labels, encodeLabelImage(labels(camera, t, label)), t);
      }
    }
    pipeline.stepReady(t);
  }
  pipeline.finish(kStart_us + kFrames * kPeriod_us);
  return {*loaded, **rig, pipeline.counts(), pipeline.frames()};
}

class ShippedRig : public testing::TestWithParam<std::pair<const char*, ClassId>> {};

TEST_P(ShippedRig, StartsAndLabelsWhatItsSensorsSend) {
  const Started started = start(GetParam().first, GetParam().second);
  EXPECT_EQ(started.frames, kFrames);
  ASSERT_TRUE(started.counts.rig);
  EXPECT_TRUE(started.counts.rig->troubles.empty()) << started.counts.rig->troubles.begin()->first;
  EXPECT_GT(started.counts.rig->labels.labelled, started.counts.rig->labels.points / 2);
  EXPECT_NE(started.loaded.classes.find(kUnknownClass), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Robots, ShippedRig,
                         testing::Values(std::pair("spot_odin1", ClassId{50}), std::pair("rgbd", ClassId{2}),
                                         std::pair("kitti_hdl64_cam", ClassId{50})));

TEST(RigInput, WithoutLabelsThereIsStillAMapOfTheUnknown) {
  auto loaded = loadConfig(HGG_SOURCE_DIR "/firmware_cfg/spot_odin1/hggmap.toml");
  ASSERT_TRUE(loaded);
  const auto rig = takeRig(*loaded);
  Mapper mapper(loaded->config, loaded->classes);
  Pipeline pipeline(mapper, {}, OdometryWait::kUnlimited, *rig);
  for (int k = 0; k < kFrames; ++k) {
    const Micros t = kStart_us + k * kPeriod_us;
    pipeline.addOdometry(encodePose(t, Pose::Identity()), t);
    pipeline.addCloud(encodeCloud(t, wall()), t);
    pipeline.stepReady(t);
  }
  pipeline.finish(kStart_us + kFrames * kPeriod_us);
  EXPECT_EQ(pipeline.frames(), kFrames);
  ASSERT_FALSE(mapper.map().nodes().empty());
  for (const auto& [id, node] : mapper.map().nodes()) {
    EXPECT_EQ(node.label, kUnknownClass);
    EXPECT_TRUE(node.stuff);
  }
  EXPECT_EQ(pipeline.counts().rig->troubles.at("front: no image in time"), kFrames);
}

TEST(RigInput, MessagesOfAnotherKindAreCountedByTheirSensor) {
  auto loaded = loadConfig(HGG_SOURCE_DIR "/firmware_cfg/spot_odin1/hggmap.toml");
  ASSERT_TRUE(loaded);
  const auto rig = takeRig(*loaded);
  Mapper mapper(loaded->config, loaded->classes);
  Pipeline pipeline(mapper, {}, OdometryWait::kUnlimited, *rig);
  const std::vector<std::uint8_t> garbage = {1, 2, 3};
  pipeline.addRigMessage("CAMERA_LABELS_front", garbage, kStart_us);
  pipeline.addRigMessage("CAMERA_LABELS_front", encodePose(kStart_us, Pose::Identity()), kStart_us);
  pipeline.addCloud(garbage, kStart_us);
  pipeline.addCloud(encodeLabelImage(labels((*rig)->cameras[0], kStart_us, 50)), kStart_us);
  pipeline.finish(kStart_us);
  EXPECT_EQ(pipeline.counts().rig->troubles.at("front: not a label image"), 2);
  EXPECT_EQ(pipeline.counts().drops.causes.at("cloud: unreadable"), 2);
  EXPECT_EQ(pipeline.frames(), 0);
}

TEST(RigInput, AConfigWithoutARigFileHasNone) {
  auto loaded = loadConfig(HGG_SOURCE_DIR "/firmware_cfg/semantickitti/hggmap.toml");
  ASSERT_TRUE(loaded);
  const auto rig = takeRig(*loaded);
  ASSERT_TRUE(rig);
  EXPECT_FALSE(*rig);
  EXPECT_EQ(loaded->config.lcm.lidar_semantic, "LIDAR_SEMANTIC");
  EXPECT_EQ(loaded->classes.find(kUnknownClass), nullptr);
}

TEST(RigInput, ARigFileThatIsNotThereIsSaid) {
  LoadedConfig loaded{Config{}, ClassTable::builtin(), "/nonexistent/rig.toml"};
  EXPECT_NE(takeRig(loaded).error.find("/nonexistent/rig.toml: cannot read the rig file"), std::string::npos);
}

}  // namespace
}  // namespace hgg::rig_input_test
