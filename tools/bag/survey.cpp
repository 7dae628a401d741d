#include "bag/survey.h"

#include <algorithm>

namespace hgg {
namespace {

constexpr std::size_t kMostSteps = 64;  // from a frame to the root of its tree: a loop of frames ends there

/// What the message adds to what is known of its topic; false when it cannot be read.
bool look(const BagMessage& message, BagTopic& topic, BagSurvey& survey) {
  if (message.type == "sensor_msgs/PointCloud2") {
    const auto cloud = readCloud(message);
    if (cloud && topic.fields.empty()) {
      topic.frame = cloud->header.frame;
      for (const RosField& field : cloud->fields) {
        topic.fields.push_back(field.name);
      }
    }
    return cloud.has_value();
  }
  if (message.type == "nav_msgs/Odometry") {
    const auto odometry = readOdometry(message);
    if (odometry && topic.frame.empty()) {
      topic.frame = odometry->header.frame, topic.child = odometry->child;
    }
    return odometry.has_value();
  }
  if (message.type == "sensor_msgs/Image") {
    const auto image = readImage(message);
    if (image && topic.encoding.empty()) {
      topic.frame = image->header.frame, topic.encoding = image->encoding;
      topic.width = image->width, topic.height = image->height;
    }
    return image.has_value();
  }
  if (message.type == "sensor_msgs/CameraInfo") {
    const auto camera = readCamera(message);
    if (camera) {
      topic.frame = camera->header.frame;
      survey.cameras.emplace(topic.name, *camera);
    }
    return camera.has_value();
  }
  if (holdsTransforms(message.type)) {
    const auto transforms = readTransforms(message);
    const bool is_static = message.topic.ends_with("tf_static");
    for (const RosTransform& t : transforms.value_or(std::vector<RosTransform>())) {
      if (is_static) {
        survey.fixed[t.child] = t;
      } else {
        survey.moving[t.child] = t.header.frame;
      }
    }
    return transforms.has_value();
  }
  return true;
}

/// The frame that all above a frame stand still against, and the transform from it.
std::pair<std::string, Pose> rootOf(const BagSurvey& survey, std::string frame) {
  Pose T_root_frame = Pose::Identity();
  for (std::size_t k = 0; k < kMostSteps; ++k) {
    const auto up = survey.fixed.find(frame);
    if (up == survey.fixed.end()) {
      break;
    }
    T_root_frame = up->second.T_parent_child.pose() * T_root_frame;
    frame = up->second.header.frame;
  }
  return {frame, T_root_frame};
}

}  // namespace

Result<BagSurvey> surveyBag(const std::filesystem::path& path, const BagProgress& progress) {
  BagSurvey survey;
  std::map<std::string, BagTopic> topics;
  const auto visit = [&](const BagMessage& message) {
    BagTopic& topic = topics[message.topic];
    if (topic.messages == 0) {
      topic.name = message.topic, topic.type = message.type, topic.first_ns = message.stamp_ns;
    }
    topic.last_ns = std::max(topic.last_ns, message.stamp_ns);
    ++topic.messages;
    topic.unread += look(message, topic, survey) ? 0 : 1;
    return true;
  };
  Result<BagEnd> end = readBag(path, visit, progress);
  if (!end) {
    return Result<BagSurvey>::fail(end.error);
  }
  for (auto& [name, topic] : topics) {
    survey.topics.push_back(std::move(topic));
  }
  survey.end = std::move(*end);
  return Result<BagSurvey>::ok(std::move(survey));
}

std::optional<RosPose> fixedTransform(const BagSurvey& survey, const std::string& parent, const std::string& child) {
  if (parent == child) {
    return RosPose{};
  }
  const auto [root_parent, T_root_parent] = rootOf(survey, parent);
  const auto [root_child, T_root_child] = rootOf(survey, child);
  if (root_parent != root_child) {
    return std::nullopt;
  }
  const Pose T_parent_child = T_root_parent.inverse() * T_root_child;
  return RosPose{T_parent_child.translation(), Eigen::Quaterniond(T_parent_child.linear())};
}

}  // namespace hgg
