#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "map/node.h"
#include "map/region.h"

namespace hgg {

/// Where the robot is, once a frame.
struct PoseUpdate {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
  Pose T_map_odom = Pose::Identity();
};

/// How an object moves, map frame.
struct ObjectMotion {
  Vec3 velocity = Vec3::Zero();      // m/s
  Mat3 velocity_cov = Mat3::Zero();  // m^2/s^2
};

/// An object node without its geometry, or something that moves: what subscribers see of it. Fields of hgg.object_t;
/// those of it that are not here nobody computes yet, and they go out as not known.
struct ObjectSummary {
  NodeId id = 0;
  ClassId label = 0;
  std::string name;
  Belief belief;                     // map frame
  Mat3 position_cov = Mat3::Zero();  // m^2: how well the mean is known in the map
  Mat3 relative_cov = Mat3::Zero();  // m^2: the same as if the pose of the anchor were exact
  KeyframeId anchor = -1;            // the keyframe it moves rigidly with; -1 for none
  bool stuff = false;
  double existence = 1, class_probability = 1;
  ClassWeights classes;  // probability of each class its place was taken for; empty when not known
  std::int32_t views = 0, leaves = 0;
  Micros first_us = 0, last_us = 0;
  std::optional<ObjectMotion> motion = std::nullopt;  // of what moves
};

/// A change of the object graph, or the whole of it.
struct GraphUpdate {
  Micros utime_us = 0;
  std::int64_t revision = 0;
  bool complete = false;
  std::vector<ObjectSummary> objects;  // ascending id; all that moves now is among them
  std::vector<NodeId> removed;         // ascending; absorbed, faded, not (any more) confirmed, or moved until now
  std::vector<Edge> edges;             // all edges with an end among `objects`
};

/// The level above objects, always all of it; fields of hgg.regions_t.
struct RegionsUpdate {
  Micros utime_us = 0;
  std::int64_t revision = 0;  // of the map that they were found in
  Regions found;
};

/// Something that is wrong now; fields of hgg.alarm_t.
struct Alarm {
  bool is_serious = false;  // the map or the pose is not to be trusted
  std::string code;         // for programs, never renamed: "lost", "odometry_lag"
  std::string subject;      // the channel it is about; may be empty
  std::string text;         // one sentence for people
};

/// What a supervisor acts on; values of hgg.status_t.
enum class HealthState : std::uint8_t { kUnknown = 0, kOk = 1, kDegraded = 2, kLost = 3 };

/// Health of a mapper; fields of hgg.status_t. Those of it that are not here nobody computes yet, and they go out as
/// not known.
struct Status {
  Micros utime_us = 0;
  HealthState state = HealthState::kUnknown;
  std::int64_t fragment = 0;  // of the map that the robot is in, named by its oldest keyframe; 0: the first one
  double position_sigma = 0;  // m, of the robot's place against the map around it, worst axis; 0: not known
  double heading_sigma = 0;   // rad; 0: not known
  std::vector<Alarm> alarms;
  std::int64_t frames = 0;
  std::int64_t dropped_busy = 0, dropped_odometry = 0, dropped_invalid = 0;
  std::vector<std::pair<std::string, std::int64_t>> drops;  // every loss in detail, odometry's included
  double frame_rate = 0;                                    // Hz
  double frame_ms = 0;
  std::vector<std::pair<std::string, double>> stage_ms;
  std::int64_t objects = 0, leaves = 0;
  std::int64_t keyframes = 0, loops = 0;  // loops: closed since the map was begun
  double map_mb = 0, rss_mb = 0;
  std::int64_t unknown_labels = 0;
  std::int64_t revision = 0;
  std::string alignment;  // how the last pose came about
  int degenerate = 0;     // directions in which it is odometry's
};

/// One layer of a grid: number (level * height + row) * width + column is the value of that cell; NaN where it has
/// none.
struct GroundLayer {
  std::string name;
  std::vector<float> values;
};

/// Where a robot can walk; fields of hgg.traversability_t.
struct GroundGrid {
  Micros utime_us = 0;
  std::int64_t revision = 0;
  double x = 0, y = 0;     // m, map frame: corner of cell (0, 0) with the least x and y
  double resolution = 0;   // m, edge of a cell
  double reference_z = 0;  // m, map frame: level 0 of a column is the surface nearest to it
  std::int32_t width = 0, height = 0, levels = 1;
  std::vector<std::uint8_t> cost;
  std::vector<GroundLayer> layers;
};

/// An OctoMap, in the bytes of OcTree::writeBinaryConst; fields of octomap.raw_t.
struct OctomapBytes {
  Micros utime_us = 0;
  std::string bytes;
};

/// What a command asks for; values of hgg.command_t. Others come, too: they are refused.
enum class CommandKind : std::int8_t {
  kSave = 1,
  kReset = 2,
  kResendAll = 3,
  kPublishGeometry = 4,
  kPublishOctomap = 5,
  kPublishTraversability = 6
};

/// A command as it came; numbers are whatever the sender wrote. Fields of hgg.command_t.
struct Command {
  std::string client;
  std::int64_t request_id = 0;
  CommandKind kind{};
  std::optional<std::array<double, 4>> region;  // m, map frame: x_min, y_min, x_max, y_max; nothing: all of the map
  double reference_z = 0;                       // m, map frame
  double resolution = 0;                        // m; 0: as configured
};

/// The answer to a command; fields of hgg.command_reply_t.
struct CommandReply {
  Micros utime_us = 0;  // of the newest frame in the map
  std::string client;
  std::int64_t request_id = 0;
  CommandKind kind{};
  bool ok = false;
  std::string text;           // one sentence: what was done, or why not
  std::int64_t revision = 0;  // of the map that was sent
  double ms = 0;              // it took
};

/// "Go to the bench next to the tree", as it came; numbers are whatever the sender wrote. Fields of hgg.goal_query_t.
struct GoalQuery {
  std::string client;
  std::int64_t request_id = 0;
  std::string text;
  std::optional<std::array<double, 4>> start;  // x, y, z [m] and yaw [rad], map frame; z may be NaN: the ground there
  std::int32_t max_answers = 0;                // 0: as many as are usual
  bool with_goal = false;
};

/// One thing that may be meant; fields of hgg.goal_answer_t.
struct GoalAnswer {
  NodeId id = 0;
  std::string name;
  double probability = 0;
  Vec3 mean = Vec3::Zero();  // m, map frame
  Mat3 cov = Mat3::Zero();   // m^2, extent
  std::string reason;        // one sentence
};

/// Values of hgg.goal_reply_t.
enum class GoalStatus : std::int8_t { kOk = 1, kAmbiguous = 2, kNotFound = 3, kNotUnderstood = 4, kFailed = 5 };
enum class GoalKind : std::int8_t { kNone = 0, kReachable = 1, kNearest = 2 };

/// The answer to a goal query; fields of hgg.goal_reply_t.
struct GoalReply {
  Micros utime_us = 0;  // of the newest frame in the map
  std::string client;
  std::int64_t request_id = 0;
  std::int64_t revision = 0;
  GoalStatus status = GoalStatus::kFailed;
  std::string text;   // one sentence: why there is no answer, or more than one
  std::string parse;  // JSON: how the words were understood
  std::vector<GoalAnswer> answers;
  GoalKind goal_kind = GoalKind::kNone;
  Vec3 goal = Vec3::Zero();  // m, map frame, on the ground
  double goal_yaw = 0;       // rad
  std::string goal_reason;
  double path_length = 0, path_confidence = 0;
  std::vector<Vec3> path;  // m, map frame, on the ground
};

/// Where messages go: the bus, the log, a viewer. A sink leaves empty what it has no use for. Calls come one at a time,
/// from the thread that maps, so a slow sink holds up the next frame; those of `ground`, `octomap` and `regions` come
/// one at a time from another thread, and those of `goal` from a third, beside the others; they may take their time.
struct Sink {
  std::function<void(const PoseUpdate&)> pose;
  std::function<void(const GraphUpdate&)> graph;
  std::function<void(const Status&)> status;
  std::function<void(const std::string&)> warning;  // one line for whoever looks after the robot
  std::function<std::int64_t()> take_unsent;        // messages it could not deliver since it was last asked
  std::function<void(const GroundGrid&)> ground = nullptr;
  std::function<void(const OctomapBytes&)> octomap = nullptr;
  std::function<void(const CommandReply&)> reply = nullptr;
  std::function<void(const GoalReply&)> goal = nullptr;
  std::function<void(const RegionsUpdate&)> regions = nullptr;
};

}  // namespace hgg
