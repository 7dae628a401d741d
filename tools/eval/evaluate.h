#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/geometry.h"
#include "eval/ghosts.h"
#include "eval/loops.h"
#include "eval/objects.h"
#include "eval/plans.h"
#include "eval/recovery.h"
#include "eval/retrieval.h"
#include "eval/rooms.h"
#include "eval/trajectory.h"
#include "eval/walk.h"

namespace hgg {

struct EvalOptions {
  std::filesystem::path map, graph;  // one of them: map.hgg or graph JSON
  std::filesystem::path truth;       // directory with gt_objects.json; cloud.ply, queries.jsonl, classes.toml: if there
  std::filesystem::path trajectory;  // TUM; empty: the map's frame is taken to be the truth's
  std::filesystem::path poses;       // true poses; empty: truth/poses.txt
  std::filesystem::path times;       // of the true poses; empty: truth/times.txt, else the log's, else by row
  std::filesystem::path log;         // the mapper's input, for its odometry; empty: odometry is not scored
  std::filesystem::path live;     // poses as they were published, with their status; empty: beside the map when there
  double fault = 0;               // s after the first true pose: when something went wrong
  std::filesystem::path stats;    // stats.json of the run; empty: beside the map when there
  std::filesystem::path answers;  // of hggmap query --batch (not yet) to the queries; empty: retrieval is not scored
  std::filesystem::path grid;     // F.layers.json of hggmap export --format grid; empty: it is not scored
  std::filesystem::path plan_requests;  // pairs to plan between: written here where `plans` asks for some, else read
  std::filesystem::path plan_answers;   // of hggmap plan --batch to them; empty: plans are not scored
  int plans = 0;                        // pairs to draw and write
  std::string odometry_channel = "POSE_ODOM", cloud_channel = "LIDAR_SEMANTIC";  // of the log
  double radius = 1.5;                                                           // m
  double spacing = 0.1;              // m, of the points geometry is compared over
  std::vector<std::string> classes;  // names or ids; empty: all
};

struct TrajectoryScore {
  std::size_t pairs = 0;
  double ate = 0;                       // m
  Pose T_truth_map = Pose::Identity();  // applied to the predictions before matching
  RelativeError relative;
  double share = 0;   // of the true poses that have a partner: those without cannot count against the trajectory
  double height = 0;  // m, the largest error along the vertical, the map laid over the truth as the predictions
  Pose T_truth_first = Pose::Identity();  // lays the first pose of the map on the true one: its frame where it belongs
};

/// The grid of where one can walk, beside the truth's.
struct GridScore {
  WalkScore whole;                       // the map laid over the truth by one transform
  std::optional<WalkScore> local;        // every place by the nearest pose; needs the trajectory
  std::map<ClassId, std::string> names;  // of the causes in `whole`
};

/// One pose sequence beside the truth: what a picture needs.
struct Path {
  std::vector<PosePair> pairs;
  Pose T_truth_estimate = Pose::Identity();  // where to draw the estimate
};

/// Everything in the truth's frame.
struct Scenery {
  std::vector<MappedObject> predictions;
  std::vector<TruthObject> truth;
  std::optional<Path> corrected, odometry;
};

struct Evaluation {
  double radius = 0;
  std::map<ClassId, std::string> class_names;
  ObjectEvaluation objects;
  std::vector<Ghost> ghosts;  // the overall ones, with their causes
  std::vector<Twins> twins;
  MovingScore moving;
  std::optional<TrajectoryScore> trajectory;
  std::optional<Calibration> neighbours;  // how found objects lie to each other; needs the map itself
  std::optional<RecoveryScore> recovery;
  std::optional<TrajectoryScore> odometry;  // the mapper's input by the same measure
  std::optional<GeometryScore> geometry;
  std::optional<RetrievalScore> retrieval;
  std::optional<LoopScore> loops;
  std::optional<GridScore> grid;
  std::optional<PlanScore> plans;
  std::optional<RoomScore> rooms;
  nlohmann::json cost;  // stats.json, null without one
  Scenery scenery;
};

/// Reads what the options name and scores it.
Result<Evaluation> evaluate(const EvalOptions& options);

}  // namespace hgg
