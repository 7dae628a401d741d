#include "convert/rosbag.h"

#include <algorithm>

#include "bag/ros_cloud.h"
#include "bus/codec.h"
#include "bus/log.h"

namespace hgg {
namespace {

constexpr std::int64_t kMicro_ns = 1000;
constexpr std::size_t kMostFrames = 64;  // of a chain of transforms

using Plan = Result<RosbagPlan>;

std::vector<const BagTopic*> topicsOf(const BagSurvey& survey, const std::string& type) {
  std::vector<const BagTopic*> found;
  for (const BagTopic& topic : survey.topics) {
    if (topic.type == type && topic.messages > topic.unread) {
      found.push_back(&topic);
    }
  }
  return found;
}

std::string namesOf(const std::vector<const BagTopic*>& topics) {
  std::string names;
  for (const BagTopic* topic : topics) {
    names += (names.empty() ? "" : ", ") + topic->name;
  }
  return names;
}

bool hasField(const BagTopic& topic, const std::string& name) {
  return std::ranges::find(topic.fields, name) != topic.fields.end();
}

/// The first of these fields that the cloud has; empty: none.
std::string fieldOf(const BagTopic& topic, const std::string& asked, const std::vector<std::string>& usual) {
  if (!asked.empty()) {
    return asked;
  }
  const auto found = std::ranges::find_if(usual, [&](const std::string& name) { return hasField(topic, name); });
  return found != usual.end() ? *found : "";
}

const std::vector<std::string> kLabelFields{"label", "labels", "class", "class_id", "semantic", "semantic_id"};
const std::vector<std::string> kInstanceFields{"instance", "instance_id", "id"};

/// The topic of that name, else the best one: with labels before without, then the one with the most messages.
Result<const BagTopic*> cloudOf(const BagSurvey& survey, const RosbagOptions& options) {
  using Found = Result<const BagTopic*>;
  const std::vector<const BagTopic*> clouds = topicsOf(survey, "sensor_msgs/PointCloud2");
  if (clouds.empty()) {
    return Found::fail("no topic of sensor_msgs/PointCloud2 in the bag (--list shows what there is)");
  }
  if (!options.cloud.empty()) {
    const auto named = std::ranges::find(clouds, options.cloud, &BagTopic::name);
    return named != clouds.end() ? Found::ok(*named)
                                 : Found::fail("no cloud on topic " + options.cloud + "; there are " + namesOf(clouds));
  }
  const auto worth = [&](const BagTopic* topic) {
    return std::pair(!fieldOf(*topic, options.label_field, kLabelFields).empty(), topic->messages);
  };
  return Found::ok(*std::ranges::max_element(clouds, {}, worth));
}

/// The frames from the body up to the one that moves least: of /tf and /tf_static, nearest first.
std::vector<std::string> framesAbove(const BagSurvey& survey, std::string frame) {
  std::vector<std::string> frames;
  while (frames.size() < kMostFrames) {
    const auto moving = survey.moving.find(frame);
    const auto fixed = survey.fixed.find(frame);
    if (moving == survey.moving.end() && fixed == survey.fixed.end()) {
      break;
    }
    frame = moving != survey.moving.end() ? moving->second : fixed->second.header.frame;
    frames.push_back(frame);
  }
  return frames;
}

/// The odometry of /tf: the frames to go up from the body.
std::string planChain(const BagSurvey& survey, const RosbagOptions& options, const std::string& cloud_frame,
                      RosbagPlan& plan) {
  plan.body_frame = !options.body_frame.empty() ? options.body_frame : cloud_frame;
  // A sensor is fixed to the body: the frame above all that is fixed is the body's.
  for (std::size_t k = 0; options.body_frame.empty() && k < kMostFrames; ++k) {
    const auto up = survey.fixed.find(plan.body_frame);
    if (up == survey.fixed.end()) {
      break;
    }
    plan.body_frame = up->second.header.frame;
  }
  const std::vector<std::string> above = framesAbove(survey, plan.body_frame);
  if (above.empty()) {
    return "the bag has no nav_msgs/Odometry, and no transform of /tf moves " + plan.body_frame +
           " (--body-frame names another frame; --list shows what there is)";
  }
  const auto odom = std::ranges::find_if(above, [&](const std::string& frame) {
    return options.odom_frame.empty() ? frame.find("odom") != std::string::npos : frame == options.odom_frame;
  });
  if (odom == above.end() && !options.odom_frame.empty()) {
    return "no transforms lead from " + plan.body_frame + " to " + options.odom_frame;
  }
  plan.odom_frame = odom != above.end() ? *odom : above.back();
  plan.chain = {plan.body_frame};
  for (const std::string& frame : above) {
    if (frame == plan.odom_frame) {
      break;
    }
    plan.chain.push_back(frame);
  }
  return "";
}

std::string planOdometry(const BagSurvey& survey, const RosbagOptions& options, const std::string& cloud_frame,
                         RosbagPlan& plan) {
  const std::vector<const BagTopic*> odometries = topicsOf(survey, "nav_msgs/Odometry");
  if (options.odometry == "tf" || (options.odometry.empty() && odometries.empty())) {
    return planChain(survey, options, cloud_frame, plan);
  }
  const auto named = std::ranges::find(odometries, options.odometry, &BagTopic::name);
  if (!options.odometry.empty() && named == odometries.end()) {
    return "no nav_msgs/Odometry on topic " + options.odometry +
           (odometries.empty() ? "; the bag has none" : "; there are " + namesOf(odometries)) + " (or tf)";
  }
  if (options.odometry.empty() && odometries.size() > 1) {
    return "several topics hold odometry: " + namesOf(odometries) + "; --odometry says which one";
  }
  const BagTopic& odometry = options.odometry.empty() ? *odometries.front() : **named;
  plan.odometry = odometry.name, plan.odom_frame = odometry.frame;
  plan.body_frame = !options.body_frame.empty() ? options.body_frame
                    : odometry.child.empty()    ? cloud_frame
                                                : odometry.child;
  const auto T_child_body =
      odometry.child.empty() ? RosPose{} : fixedTransform(survey, odometry.child, plan.body_frame);
  if (!T_child_body) {
    return "no transform of /tf_static leads from " + odometry.child + ", which the odometry is of, to " +
           plan.body_frame;
  }
  plan.is_other_body = !odometry.child.empty() && odometry.child != plan.body_frame;
  plan.T_child_body = T_child_body->pose();
  return "";
}

/// Poses of the body against the odometry's frame, put together from single transforms.
class Chain {
 public:
  Chain(const BagSurvey& survey, const RosbagPlan& plan) : frames_(plan.chain) {
    for (const std::string& frame : frames_) {
      if (const auto fixed = survey.fixed.find(frame); fixed != survey.fixed.end() && !survey.moving.contains(frame)) {
        T_parent_child_[frame] = fixed->second.T_parent_child.pose();
      }
    }
  }

  /// The body's pose after a transform, when that moved it and all others are known.
  std::optional<Pose> add(const RosTransform& t) {
    if (std::ranges::find(frames_, t.child) == frames_.end()) {
      return std::nullopt;
    }
    T_parent_child_[t.child] = t.T_parent_child.pose();
    if (T_parent_child_.size() < frames_.size()) {
      return std::nullopt;
    }
    Pose T_odom_body = Pose::Identity();
    for (const std::string& frame : frames_) {  // from the body upwards
      T_odom_body = T_parent_child_[frame] * T_odom_body;
    }
    return T_odom_body;
  }

 private:
  std::vector<std::string> frames_;
  std::map<std::string, Pose> T_parent_child_;
};

class Converter {
 public:
  Converter(const BagSurvey& survey, const RosbagPlan& plan, LogWriter& log)
      : plan_(plan), log_(log), chain_(survey, plan) {}

  const std::string& error() const { return error_; }
  const RosbagCount& count() const { return count_; }

  /// False when the log cannot be written.
  bool take(const BagMessage& message) {
    if (message.topic == plan_.cloud) {
      takeCloud(message);
    } else if (!plan_.odometry.empty() && message.topic == plan_.odometry) {
      takeOdometry(message);
    } else if (plan_.odometry.empty() && holdsTransforms(message.type)) {
      takeTransforms(message);
    }
    return error_.empty();
  }

 private:
  void write(const char* channel, Micros utime_us, const std::vector<std::uint8_t>& data, std::int64_t& counted) {
    error_ = log_.write(channel, utime_us, data);
    ++counted;
  }

  void takeCloud(const BagMessage& message) {
    const auto cloud = readCloud(message);
    std::optional<RosPoints> points = cloud ? pointsOf(*cloud, {plan_.label, plan_.instance}) : std::nullopt;
    if (!points) {
      ++count_.bad;
      return;
    }
    if (plan_.is_moved) {
      move(points->points, plan_.T_body_cloud);
    }
    const Micros utime_us = cloud->header.stamp_ns / kMicro_ns;
    if (plan_.label.empty()) {
      write("LIDAR", utime_us, encodeCloud(utime_us, points->points, points->times), count_.clouds);
    } else {
      write("LIDAR_SEMANTIC", utime_us, encodeSemanticCloud(utime_us, points->points, points->times), count_.clouds);
    }
  }

  void takeOdometry(const BagMessage& message) {
    const auto odometry = readOdometry(message);
    if (!odometry) {
      ++count_.bad;
      return;
    }
    const Micros utime_us = odometry->header.stamp_ns / kMicro_ns;
    if (plan_.is_other_body) {
      write("POSE_ODOM", utime_us, encodePose(utime_us, odometry->T_parent_child.pose() * plan_.T_child_body),
            count_.poses);
      return;
    }
    write("POSE_ODOM", utime_us,
          encodePose(utime_us, odometry->T_parent_child.position, odometry->T_parent_child.orientation), count_.poses);
  }

  void takeTransforms(const BagMessage& message) {
    const auto transforms = readTransforms(message);
    count_.bad += transforms ? 0 : 1;
    for (const RosTransform& t : transforms.value_or(std::vector<RosTransform>())) {
      const std::optional<Pose> T_odom_body = message.topic.ends_with("tf_static") ? std::nullopt : chain_.add(t);
      const Micros utime_us = t.header.stamp_ns / kMicro_ns;
      if (T_odom_body && error_.empty()) {
        write("POSE_ODOM", utime_us, encodePose(utime_us, *T_odom_body), count_.poses);
      }
    }
  }

  static void move(std::vector<Point>& points, const Pose& T_body_cloud) {
    for (Point& p : points) {
      const Vec3 moved = T_body_cloud * Vec3(p.x, p.y, p.z);
      p.x = static_cast<float>(moved.x()), p.y = static_cast<float>(moved.y()), p.z = static_cast<float>(moved.z());
    }
  }

  const RosbagPlan& plan_;
  LogWriter& log_;
  Chain chain_;
  RosbagCount count_;
  std::string error_;
};

}  // namespace

Result<RosbagPlan> planRosbag(const BagSurvey& survey, const RosbagOptions& options) {
  const Result<const BagTopic*> cloud = cloudOf(survey, options);
  if (!cloud) {
    return Plan::fail(cloud.error);
  }
  RosbagPlan plan;
  const BagTopic& topic = **cloud;
  plan.cloud = topic.name, plan.cloud_frame = topic.frame;
  plan.label = fieldOf(topic, options.label_field, kLabelFields);
  plan.instance = fieldOf(topic, options.instance_field, kInstanceFields);
  for (const std::string& name : {plan.label, plan.instance}) {
    if (!name.empty() && !hasField(topic, name)) {
      return Plan::fail("the clouds of " + plan.cloud + " have no field " + name + " (--list shows those they have)");
    }
  }
  if (std::string error = planOdometry(survey, options, topic.frame, plan); !error.empty()) {
    return Plan::fail(std::move(error));
  }
  if (!options.cloud_is_body) {
    const auto T_body_cloud = fixedTransform(survey, plan.body_frame, plan.cloud_frame);
    if (!T_body_cloud) {
      return Plan::fail("no transform of /tf_static leads from " + plan.body_frame + ", which the odometry is of, to " +
                        plan.cloud_frame +
                        ", which the clouds are in: --cloud-is-body takes the clouds as they are, "
                        "--body-frame names another body");
    }
    plan.is_moved = plan.body_frame != plan.cloud_frame;
    plan.T_body_cloud = T_body_cloud->pose();
  }
  return Plan::ok(std::move(plan));
}

Result<RosbagCount> convertRosbag(const std::filesystem::path& bag, const BagSurvey& survey, const RosbagPlan& plan,
                                  const std::filesystem::path& log, const BagProgress& progress) {
  std::error_code ignored;
  if (std::filesystem::equivalent(bag, log, ignored)) {
    return Result<RosbagCount>::fail("the log would replace the bag " + bag.string() + ": give another name");
  }
  const std::filesystem::path part = log.string() + ".part";
  auto writer = LogWriter::create(part.string());
  if (!writer) {
    return Result<RosbagCount>::fail(writer.error);
  }
  Converter converter(survey, plan, *writer);
  const Result<BagEnd> end = readBag(
      bag, [&](const BagMessage& message) { return converter.take(message); }, progress);
  std::string error = !end ? end.error : converter.error();
  if (error.empty()) {
    error = writer->close();
  }
  if (error.empty()) {
    std::filesystem::rename(part, log, ignored);
    error = ignored ? "cannot write " + log.string() + ": " + ignored.message() : "";
  }
  if (!error.empty()) {
    std::filesystem::remove(part, ignored);
    return Result<RosbagCount>::fail(std::move(error));
  }
  RosbagCount count = converter.count();
  count.damage = end->damage;
  return Result<RosbagCount>::ok(std::move(count));
}

}  // namespace hgg
