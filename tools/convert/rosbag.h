#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bag/survey.h"

namespace hgg {

/// What of a bag becomes what; what is left empty is guessed.
struct RosbagOptions {
  std::string cloud;     // topic of sensor_msgs/PointCloud2
  std::string odometry;  // topic of nav_msgs/Odometry; "tf": the transforms of /tf
  std::string odom_frame, body_frame;
  std::string label_field, instance_field;  // of the cloud
  bool cloud_is_body = false;               // the cloud's frame is the body's, whatever their names
};

/// What is done with a bag.
struct RosbagPlan {
  std::string cloud, odometry;  // topics; odometry empty: the chain of transforms
  std::string odom_frame, body_frame, cloud_frame;
  Pose T_body_cloud = Pose::Identity();
  bool is_moved = false;                 // the cloud's frame is another than the body's
  Pose T_child_body = Pose::Identity();  // of the frame that the odometry is of
  bool is_other_body = false;            // that is another than the body's
  std::string label, instance;           // fields; empty: there is none
  std::vector<std::string> chain;        // frames from the body up to, without, the odometry's
};

/// The guess, or why it cannot be made and which options would make it.
Result<RosbagPlan> planRosbag(const BagSurvey& survey, const RosbagOptions& options);

/// What was written, and what could not be.
struct RosbagCount {
  std::int64_t clouds = 0, poses = 0;
  std::int64_t bad = 0;  // messages that could not be read
  std::string damage;    // of the bag, as in BagEnd
};

/// Writes LIDAR_SEMANTIC (LIDAR where the cloud has no labels) and POSE_ODOM of the bag's headers' stamps. Values are
/// taken as they are: coordinates change only where the cloud's frame is not the body's.
Result<RosbagCount> convertRosbag(const std::filesystem::path& bag, const BagSurvey& survey, const RosbagPlan& plan,
                                  const std::filesystem::path& log, const BagProgress& progress);

}  // namespace hgg
