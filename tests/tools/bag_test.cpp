#include "bag/bag.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bag/ros_cloud.h"
#include "bag/survey.h"
#include "bus/codec.h"
#include "bus/log.h"
#include "convert/rosbag.h"

namespace hgg::bag_test {
namespace {

namespace fs = std::filesystem;

// Written by a writer that is not ours (tests/data/bags/make_ros2_bag.mjs): three points seen twice by a LiDAR that
// looks backwards.
const fs::path kRos2 = fs::path(HGG_TEST_DATA) / "bags" / "two_frames.db3";

fs::path scratch(const std::string& name) {
  const fs::path dir = fs::path(testing::TempDir()) / "hgg_bag_test";
  fs::create_directories(dir);
  return dir / name;
}

std::vector<std::pair<std::string, std::vector<std::uint8_t>>> messagesOf(const fs::path& bag) {
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> messages;
  readBag(
      bag,
      [&](const BagMessage& m) {
        messages.emplace_back(m.type, std::vector<std::uint8_t>(m.data.begin(), m.data.end()));
        return true;
      },
      nullptr);
  return messages;
}

TEST(Bag, ARos2BagOfAnotherMakersWriterIsConvertedToTheLastBit) {
  const auto survey = surveyBag(kRos2, nullptr);
  ASSERT_TRUE(survey) << survey.error;
  const auto plan = planRosbag(*survey, {});
  ASSERT_TRUE(plan) << plan.error;
  EXPECT_EQ(plan->body_frame, "base_link");
  const fs::path log = scratch("ros2.lcm");
  const auto count = convertRosbag(kRos2, *survey, *plan, log, nullptr);
  ASSERT_TRUE(count) << count.error;
  EXPECT_EQ(count->clouds, 2);
  EXPECT_EQ(count->poses, 2);
  auto reader = LogReader::open(log.string());
  ASSERT_TRUE(reader);
  reader->next(), reader->next();  // the first frame
  const auto pose_event = reader->next(), cloud_event = reader->next();
  ASSERT_TRUE(pose_event && cloud_event);
  const auto pose = decodePose(pose_event->data);
  ASSERT_TRUE(pose) << pose.error;
  EXPECT_EQ(pose->utime_us, 1'700'000'000'223'456);
  EXPECT_EQ(pose->T_odom_body.translation(), Vec3(2, 0.25, -0.125));
  EXPECT_NEAR(pose->T_odom_body.linear()(1, 0), 2 * 0.6 * 0.8, 1e-12);
  const auto cloud = decodeSemanticCloud(cloud_event->data, 0);
  ASSERT_TRUE(cloud) << cloud.error;
  ASSERT_EQ(cloud->points.size(), 3U);
  const Point& p = cloud->points[2];  // (4, -4, 0.5) of a sensor turned by half a turn, 0.5 m ahead and 1 m up
  EXPECT_NEAR(p.x, -3.5, 1e-6);
  EXPECT_NEAR(p.y, 4, 1e-6);
  EXPECT_NEAR(p.z, 1.5, 1e-6);
  EXPECT_EQ(p.label, 42);
  EXPECT_EQ(p.instance, 14U);
}

TEST(Bag, MessagesCutAnywhereAreRefusedAndNeverReadBeyondTheirEnd) {
  for (const auto& [type, data] : messagesOf(kRos2)) {
    for (std::size_t size = 0; size < data.size(); ++size) {
      const std::vector<std::uint8_t> cut(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(size));
      const BagMessage message{"/t", type, 0, BagWire::kCdr, cut};
      if (type == "tf2_msgs/TFMessage") {
        EXPECT_FALSE(readTransforms(message));
      } else if (type == "sensor_msgs/PointCloud2") {
        const auto cloud = readCloud(message);
        EXPECT_TRUE(!cloud || size + 1 == data.size());  // the flag at the end is not asked for
      } else {
        readOdometry(message);
      }
    }
  }
}

TEST(Bag, ACloudThatClaimsMorePointsThanItsDataHasIsNoCloud) {
  for (const auto& [type, data] : messagesOf(kRos2)) {
    if (type == "sensor_msgs/PointCloud2") {
      auto cloud = readCloud({"/points", type, 0, BagWire::kCdr, data});
      ASSERT_TRUE(cloud);
      const RosFieldNames names{"label", "instance"};
      EXPECT_TRUE(pointsOf(*cloud, names));
      RosCloud wide = *cloud, tall = *cloud, far = *cloud;
      wide.width = 0xffffffff, tall.height = 0x80000000, far.fields[0].offset = 0xfffffff0;
      EXPECT_FALSE(pointsOf(wide, names));
      EXPECT_FALSE(pointsOf(tall, names));
      EXPECT_FALSE(pointsOf(far, names));
    }
  }
}

TEST(Bag, SeveralOdometriesAreAskedAboutAndAFrameThatNothingJoinsIsRefused) {
  auto survey = surveyBag(kRos2, nullptr);
  ASSERT_TRUE(survey);
  BagSurvey two = *survey;
  two.topics.push_back(two.topics.front());
  two.topics.back().name = "/visual";
  EXPECT_NE(planRosbag(two, {}).error.find("--odometry"), std::string::npos);
  RosbagOptions visual;
  visual.odometry = "/visual";
  EXPECT_TRUE(planRosbag(two, visual));
  survey->fixed.clear();
  EXPECT_NE(planRosbag(*survey, {}).error.find("--cloud-is-body"), std::string::npos);
  RosbagOptions as_is;
  as_is.cloud_is_body = true;
  EXPECT_TRUE(planRosbag(*survey, as_is));
}

TEST(Bag, FramesThatGoInACircleAreNoEndlessSearch) {
  BagSurvey survey;
  survey.fixed["a"].header.frame = "b", survey.fixed["b"].header.frame = "a";
  EXPECT_FALSE(fixedTransform(survey, "a", "c"));
}

TEST(Bag, WhatIsNoBagIsRefusedByName) {
  std::ofstream(scratch("text.db3")) << "no database";
  std::ofstream(scratch("text.bag")) << "no bag";
  fs::create_directories(scratch("empty"));
  for (const char* name : {"text.db3", "text.bag", "absent.bag", "empty"}) {
    const auto end = readBag(
        scratch(name), [](const BagMessage&) { return true; }, nullptr);
    ASSERT_FALSE(end) << name;
    EXPECT_NE(end.error.find(name), std::string::npos) << end.error;
  }
}

}  // namespace
}  // namespace hgg::bag_test
