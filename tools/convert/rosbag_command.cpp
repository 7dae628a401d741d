#include "convert/rosbag_command.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "cli/progress_bar.h"
#include "convert/rosbag.h"

namespace hgg {
namespace {

constexpr int kBadInput = 2;

constexpr const char* kHelp =
    R"(Converts a ROS bag into an LCM log: ROS 1 (*.bag) or ROS 2 in SQLite storage (*.db3 or its folder).
Clouds with a field of labels become LIDAR_SEMANTIC, others LIDAR; odometry, or the transforms of /tf, becomes POSE_ODOM.
Clouds are taken to the frame that the odometry is of by the transforms of /tf_static. ROS itself is not needed.)";

struct Options {
  std::filesystem::path bag, log;
  RosbagOptions rosbag;
  bool list = false;
};

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-convert: %s\n", error.c_str());
  return kBadInput;
}

/// What the conversion would do with a topic.
std::string useOf(const BagTopic& topic, const Result<RosbagPlan>& plan) {
  const bool is_tf = holdsTransforms(topic.type);
  if (!plan) {
    return "";
  }
  if (topic.name == plan->cloud) {
    return plan->label.empty() ? "LIDAR (no labels)"
                               : fmt::format("LIDAR_SEMANTIC, labels of '{}'{}", plan->label,
                                             plan->instance.empty() ? "" : ", instances of '" + plan->instance + "'");
  }
  if (topic.name == plan->odometry) {
    return fmt::format("POSE_ODOM, {} in {}", plan->body_frame, plan->odom_frame);
  }
  if (is_tf && topic.name.ends_with("tf_static")) {
    return "where the sensors are";
  }
  return is_tf && plan->odometry.empty() ? fmt::format("POSE_ODOM, {} in {}", plan->body_frame, plan->odom_frame) : "";
}

std::string detailOf(const BagTopic& topic) {
  std::string fields;
  for (const std::string& name : topic.fields) {
    fields += (fields.empty() ? " " : ",") + name;
  }
  const std::string size = topic.width > 0 ? fmt::format(" {}x{} {}", topic.width, topic.height, topic.encoding) : "";
  return topic.frame + (topic.child.empty() ? "" : " -> " + topic.child) + fields + size;
}

int list(const BagSurvey& survey, const Result<RosbagPlan>& plan) {
  for (const BagTopic& topic : survey.topics) {
    const std::string use = useOf(topic, plan);
    fmt::print("{:<32} {:<26} {:>8} {:>8.2f} Hz  {}{}\n", topic.name, topic.type, topic.messages, topic.rate_hz(),
               detailOf(topic), use.empty() ? "" : "  => " + use);
    if (topic.unread > 0) {
      fmt::print("{:<32} {} of them cannot be read: cut, or of another definition\n", "", topic.unread);
    }
  }
  fmt::print("{}\n", plan ? fmt::format("It can be converted; clouds are in {}.", plan->cloud_frame)
                          : "It cannot be converted: " + plan.error);
  return plan ? 0 : 1;
}

int run(const Options& options) {
  ProgressBar survey_bar("look");
  const Result<BagSurvey> survey =
      surveyBag(options.bag, [&](double share) { survey_bar.show(share, options.bag.filename().string()); });
  survey_bar.finish();
  if (!survey) {
    return fail(survey.error);
  }
  if (!survey->end.damage.empty()) {
    std::fprintf(stderr, "hgg-convert: %s: %s; the %lld messages that are whole are read\n", options.bag.c_str(),
                 survey->end.damage.c_str(), static_cast<long long>(survey->end.messages));
  }
  const Result<RosbagPlan> plan = planRosbag(*survey, options.rosbag);
  if (options.list) {
    return list(*survey, plan);
  }
  if (!plan) {
    return fail(plan.error);
  }
  if (options.log.empty()) {
    return fail("-o LOG is missing (--list only shows what the bag holds)");
  }
  ProgressBar bar("convert");
  const Result<RosbagCount> count =
      convertRosbag(options.bag, *survey, *plan, options.log, [&](double share) { bar.show(share, ""); });
  bar.finish();
  if (!count) {
    return fail(count.error);
  }
  fmt::print("{} clouds of {} and {} poses of {} in {}\n", count->clouds, plan->cloud, count->poses, plan->body_frame,
             plan->odom_frame);
  if (count->bad > 0) {
    std::fprintf(stderr, "hgg-convert: %lld messages could not be read and are left out\n",
                 static_cast<long long>(count->bad));
  }
  return count->clouds > 0 && count->poses > 0 ? 0 : fail("that is no log to map: it has no clouds or no poses");
}

}  // namespace

void addRosbag(CLI::App& app, std::function<int()>& action) {
  const auto o = std::make_shared<Options>();
  CLI::App* sub = app.add_subcommand("rosbag", kHelp);
  sub->add_option("BAG", o->bag, "*.bag, *.db3, or the folder of a ROS 2 bag")->required();
  sub->add_option("-o,--output", o->log, "LCM log to write")->type_name("LOG");
  sub->add_flag("--list", o->list, "show the topics, their types and rates, and what they would be used for");
  sub->add_option("--cloud", o->rosbag.cloud, "topic of the clouds [the one with labels, or with the most messages]");
  sub->add_option("--odometry", o->rosbag.odometry, "topic of the odometry; tf: the transforms of /tf");
  sub->add_option("--label-field", o->rosbag.label_field,
                  "field of the cloud with the class [label, class, semantic..]");
  sub->add_option("--instance-field", o->rosbag.instance_field, "field with the instance [instance, id]");
  sub->add_option("--odom-frame", o->rosbag.odom_frame, "of /tf: the frame that odometry is in [*odom*]");
  sub->add_option("--body-frame", o->rosbag.body_frame, "the robot's frame [that of the odometry]");
  sub->add_flag("--cloud-is-body", o->rosbag.cloud_is_body, "the clouds are in the body's frame, whatever its name");
  sub->footer(
      "Exit codes: 0 done, 1 with --list: it cannot be converted, 2 bad input or usage.\n"
      "Example:\n  hgg-convert rosbag drive.bag --list\n  hgg-convert rosbag drive.bag -o drive.lcm");
  sub->callback([o, &action] { action = [o] { return run(*o); }; });
}

}  // namespace hgg
