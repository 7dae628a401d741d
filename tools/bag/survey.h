#pragma once

#include <map>
#include <string>
#include <vector>

#include "bag/bag.h"
#include "bag/ros_messages.h"

namespace hgg {

/// A topic of a bag and what its first message says.
struct BagTopic {
  std::string name, type;
  std::int64_t messages = 0;
  std::int64_t unread = 0;  // of those: cut, or of another definition
  std::int64_t first_ns = 0, last_ns = 0;
  std::string frame, child;             // of clouds, images and odometry
  std::vector<std::string> fields;      // of clouds
  std::string encoding;                 // of images
  std::uint32_t width = 0, height = 0;  // of images

  /// Messages a second; 0 where there is only one.
  double rate_hz() const {
    return last_ns > first_ns ? static_cast<double>(messages - 1) * 1e9 / static_cast<double>(last_ns - first_ns) : 0;
  }
};

/// What a bag holds.
struct BagSurvey {
  std::vector<BagTopic> topics;               // by name
  std::map<std::string, RosTransform> fixed;  // of /tf_static, by child
  std::map<std::string, std::string> moving;  // of /tf: parent of each child
  std::map<std::string, RosCamera> cameras;   // the first of each sensor_msgs/CameraInfo topic
  BagEnd end;
};

Result<BagSurvey> surveyBag(const std::filesystem::path& path, const BagProgress& progress);

/// T_parent_child of frames that do not move against each other; nothing where /tf_static does not join them.
std::optional<RosPose> fixedTransform(const BagSurvey& survey, const std::string& parent, const std::string& child);

}  // namespace hgg
