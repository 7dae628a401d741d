#include "eval/evaluate.h"

#include <charconv>
#include <fstream>
#include <functional>
#include <limits>

#include "bus/codec.h"
#include "bus/log.h"
#include "core/classes.h"
#include "eval/relative.h"
#include "frame/odometry_buffer.h"
#include "truth/cloud.h"
#include "truth/poses.h"

namespace hgg {
namespace {

/// Classes without a stable surface: their points and leaves are left out of the geometry, as the paper does.
const std::set<std::string> kFoliage{"vegetation", "plant"};

std::optional<ClassId> findClass(const std::string& name, const std::map<ClassId, std::string>& names) {
  for (const auto& [id, known] : names) {
    if (known == name) {
      return id;
    }
  }
  ClassId id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc() && end == name.data() + name.size() ? std::optional(id) : std::nullopt;
}

Result<std::set<ClassId>> findClasses(const std::vector<std::string>& names,
                                      const std::map<ClassId, std::string>& known) {
  std::set<ClassId> classes;
  for (const std::string& name : names) {
    const auto id = findClass(name, known);
    if (!id) {
      return Result<std::set<ClassId>>::fail("the map knows no class \"" + name + "\"");
    }
    classes.insert(*id);
  }
  return Result<std::set<ClassId>>::ok(std::move(classes));
}

/// The path asked for, else `fallback` when there is such a file, else empty.
std::filesystem::path givenOr(const std::filesystem::path& given, const std::filesystem::path& fallback) {
  std::error_code error;
  return !given.empty() || !std::filesystem::exists(fallback, error) ? given : fallback;
}

constexpr const char *kLiveName = "live.tum", *kMovingName = "moving.jsonl";

using Track = std::vector<TimedPose>;

/// The true poses and, where known, their times.
struct TruthPath {
  std::vector<Pose> T_truth_body;
  std::optional<std::vector<Micros>> times_us;
};

/// The longest gap of odometry that a config lets a mapper bridge.
constexpr Micros kWidestGap_us = 10'000'000;

/// What the mapper was fed, without the points.
struct Drive {
  OdometryBuffer odometry{kWidestGap_us, std::numeric_limits<std::size_t>::max()};
  std::vector<Micros> clouds_us;
};

/// An empty drive when no log was given.
Result<Drive> readDrive(const EvalOptions& options) {
  Drive drive;
  if (options.log.empty()) {
    return Result<Drive>::ok(std::move(drive));
  }
  auto log = LogReader::open(options.log.string());
  if (!log) {
    return Result<Drive>::fail(log.error);
  }
  while (const auto event = log->next()) {
    if (event->channel == options.cloud_channel) {
      drive.clouds_us.push_back(event->timestamp_us);
    } else if (event->channel == options.odometry_channel) {
      const auto sample = decodePose(event->data);
      if (sample) {
        drive.odometry.add(*sample);
      }
    }
  }
  drive.odometry.finish();
  return Result<Drive>::ok(std::move(drive));
}

/// The times are those given, else the log's, as there is a true pose for every cloud.
Result<TruthPath> readTruthPath(const EvalOptions& options, const Drive& drive) {
  auto poses = readPoses(options.poses.empty() ? options.truth / "poses.txt" : options.poses);
  if (!poses) {
    return Result<TruthPath>::fail(poses.error);
  }
  const auto path = givenOr(options.times, options.truth / "times.txt");
  if (path.empty()) {
    const bool fits = drive.clouds_us.size() == poses->size();
    return Result<TruthPath>::ok({std::move(*poses), fits ? std::optional(drive.clouds_us) : std::nullopt});
  }
  auto times = readTimes(path);
  return times ? Result<TruthPath>::ok({std::move(*poses), std::move(*times)}) : Result<TruthPath>::fail(times.error);
}

/// Odometry at the times of the mapper's poses, as the mapper saw it.
Result<Track> odometryAt(const OdometryBuffer& odometry, const Track& at, const EvalOptions& options) {
  Track track;
  for (const TimedPose& pose : at) {
    const auto at_pose = odometry.at(pose.utime_us);
    if (!at_pose) {
      return Result<Track>::fail(options.log.string() + ": no odometry on " + options.odometry_channel +
                                 " at a time of the trajectory: is it the log that was mapped?");
    }
    track.push_back({pose.utime_us, at_pose->T_odom_body});
  }
  return Result<Track>::ok(std::move(track));
}

TrajectoryScore score(const std::vector<PosePair>& pairs, std::size_t true_poses) {
  TrajectoryScore score;
  score.pairs = pairs.size();
  score.ate = absoluteTrajectoryError(pairs);
  score.T_truth_map = alignMap(pairs);
  score.T_truth_first = pairs.front().T_truth_body * pairs.front().T_map_body.inverse();
  score.relative = relativeError(pairs);
  score.share = static_cast<double>(pairs.size()) / static_cast<double>(true_poses);
  score.height = heightError(pairs);
  return score;
}

/// An error line, empty when done.
std::string scoreOdometry(const EvalOptions& options, const Drive& drive, const Track& estimate, const TruthPath& truth,
                          Evaluation& evaluation) {
  const auto odometry = odometryAt(drive.odometry, estimate, options);
  if (!odometry) {
    return odometry.error;
  }
  const auto pairs = pairPoses(*odometry, truth.T_truth_body, truth.times_us);
  if (!pairs) {
    return pairs.error;
  }
  evaluation.odometry = score(*pairs, truth.T_truth_body.size());
  const PosePair& first = pairs->front();  // odometry is drawn as it ran away from the start
  evaluation.scenery.odometry = Path{*pairs, first.T_truth_body * first.T_map_body.inverse()};
  return "";
}

/// Scores the poses as they were published, those corrected later where the run left no others; an error line, empty
/// when done.
std::string scoreLive(const EvalOptions& options, const TruthPath& truth, Evaluation& evaluation) {
  const auto path = givenOr(options.live, options.trajectory.parent_path() / kLiveName);
  const auto live = readLive(path.empty() ? options.trajectory : path);
  if (!live) {
    return live.error;
  }
  const auto tracked = trackPoses(*live, truth.T_truth_body, truth.times_us);
  if (!tracked) {
    return tracked.error;
  }
  const Micros start_us = truth.times_us ? truth.times_us->front() : tracked->front().utime_us;
  evaluation.recovery = scoreRecovery(*tracked, start_us + std::llround(options.fault * 1e6));
  return "";
}

/// Scores the corrected trajectory and the odometry; an error line, empty when done.
std::string scorePaths(const EvalOptions& options, Evaluation& evaluation) {
  if (options.trajectory.empty()) {
    return "";
  }
  const auto estimate = readTum(options.trajectory);
  const auto drive = readDrive(options);
  if (!estimate || !drive) {
    return !estimate ? estimate.error : drive.error;
  }
  const auto truth = readTruthPath(options, *drive);
  if (!truth) {
    return truth.error;
  }
  const auto pairs = pairPoses(*estimate, truth->T_truth_body, truth->times_us);
  if (!pairs) {
    return pairs.error;
  }
  evaluation.trajectory = score(*pairs, truth->T_truth_body.size());
  evaluation.scenery.corrected = Path{*pairs, evaluation.trajectory->T_truth_map};
  if (std::string error = scoreLive(options, *truth, evaluation); !error.empty()) {
    return error;
  }
  return options.log.empty() ? "" : scoreOdometry(options, *drive, *estimate, *truth, evaluation);
}

/// Foliage among the classes of the truth's classes.toml, else of the map, which is then free to name its classes so.
Result<std::set<ClassId>> foliageOf(const EvalOptions& options, const std::map<ClassId, std::string>& map_names) {
  std::set<ClassId> foliage;
  const auto path = givenOr({}, options.truth / "classes.toml");
  if (path.empty()) {
    for (const auto& [id, name] : map_names) {
      if (kFoliage.contains(name)) {
        foliage.insert(id);
      }
    }
    return Result<std::set<ClassId>>::ok(std::move(foliage));
  }
  const auto table = ClassTable::load(path.string());
  for (std::uint32_t label = 0; table && label <= std::numeric_limits<ClassId>::max(); ++label) {
    if (kFoliage.contains(table->name(static_cast<ClassId>(label)))) {
      foliage.insert(static_cast<ClassId>(label));
    }
  }
  return table ? Result<std::set<ClassId>>::ok(std::move(foliage)) : Result<std::set<ClassId>>::fail(table.error);
}

/// The reference cloud reaches farther than this from the way everywhere (hgg-sim: 25 m); beyond, the map cannot be
/// told right from wrong.
constexpr double kReach = 20.0;

/// The things whose middle lies within kReach of the true path.
template <typename Thing>
std::vector<Thing> alongPath(const std::vector<Thing>& things, const std::vector<Pose>& T_truth_body, auto middle_of) {
  PointSet path, middles;
  for (const Pose& pose : T_truth_body) {
    path.emplace_back(pose.translation().cast<float>());
  }
  for (const Thing& thing : things) {
    middles.emplace_back(middle_of(thing));
  }
  std::vector<Thing> kept;
  const std::vector<double> distances = nearestDistances(middles, path);
  for (std::size_t i = 0; i < things.size(); ++i) {
    if (distances[i] <= kReach) {
      kept.push_back(things[i]);
    }
  }
  return kept;
}

PointSet pointsOf(const std::vector<CloudPoint>& cloud, const std::set<ClassId>& without) {
  PointSet points;
  for (const CloudPoint& p : cloud) {
    if (!without.contains(p.label)) {
      points.emplace_back(p.x, p.y, p.z);
    }
  }
  return points;
}

std::vector<Belief> leavesOf(const std::vector<MappedObject>& objects, const std::set<ClassId>& without) {
  std::vector<Belief> leaves;
  for (const MappedObject& object : objects) {
    if (!without.contains(object.label)) {
      leaves.insert(leaves.end(), object.geometry.begin(), object.geometry.end());
    }
  }
  return leaves;
}

GeometryScore scoreAlongPath(const std::vector<Belief>& leaves, const PointSet& reference,
                             const std::vector<Pose>& T_truth_body, double spacing) {
  const auto kept = alongPath(leaves, T_truth_body, [](const Belief& leaf) { return leaf.mean.cast<float>(); });
  const PointSet estimate = sampleLeaves(kept, spacing);
  GeometryScore score = compareGeometry(estimate, reference, spacing);
  score.left_out = 1 - static_cast<double>(kept.size()) / static_cast<double>(leaves.size());  // NaN without leaves
  score.coverage = coverageOf(estimate, alongPath(thin(reference, spacing), T_truth_body, std::identity()));
  return score;
}

/// An error line, empty when done, also where the truth has no cloud.
std::string scoreGeometry(const EvalOptions& options, Evaluation& evaluation) {
  const auto path = givenOr({}, options.truth / "cloud.ply");
  if (path.empty()) {
    return "";
  }
  const auto cloud = readCloud(path);
  const auto poses = readPoses(options.poses.empty() ? options.truth / "poses.txt" : options.poses);
  const auto foliage = foliageOf(options, evaluation.class_names);
  if (!cloud || !poses || !foliage) {
    return !cloud ? cloud.error : !poses ? poses.error : foliage.error;
  }
  evaluation.geometry = scoreAlongPath(leavesOf(evaluation.scenery.predictions, *foliage), pointsOf(*cloud, *foliage),
                                       *poses, options.spacing);
  return "";
}

/// An error line, empty when done, also where there are no answers.
std::string scoreAnswers(const EvalOptions& options, Evaluation& evaluation) {
  if (options.answers.empty()) {
    return "";
  }
  const auto queries = readQueries(options.truth / "queries.jsonl");
  const auto answers = readAnswers(options.answers);
  if (!queries || !answers) {
    return !queries ? queries.error : answers.error;
  }
  const auto retrieval = scoreRetrieval(*queries, *answers, evaluation.objects.overall.matches);
  evaluation.retrieval = retrieval.value;
  return retrieval.error;
}

/// An error line, empty when done, also where the run left no statistics.
std::string readCost(const EvalOptions& options, Evaluation& evaluation) {
  const auto path = givenOr(options.stats, options.map.parent_path() / "stats.json");
  if (path.empty()) {
    return "";
  }
  std::ifstream in(path);
  evaluation.cost = nlohmann::json::parse(in, nullptr, false);
  return evaluation.cost.is_object() ? "" : path.string() + " is not the stats.json of a run";
}

/// An error line, empty when done, also where the run has no loops to tell of or no trajectory to check them by.
std::string scoreLoopsOfRun(const EvalOptions& options, Evaluation& evaluation) {
  if (!evaluation.scenery.corrected || !evaluation.cost.is_object() || !evaluation.cost.contains("loops")) {
    return "";
  }
  const auto runs = readLoops(evaluation.cost);
  if (!runs) {
    return "stats.json: " + runs.error;
  }
  evaluation.loops = scoreLoops(*runs, evaluation.scenery.corrected->pairs, revisitScale(options.radius));
  return "";
}

/// Names by the truth's classes.toml where it has one.
std::map<ClassId, std::string> namesOf(const WalkScore& score, const std::filesystem::path& truth) {
  const auto table = ClassTable::load((truth / "classes.toml").string());
  std::map<ClassId, std::string> names;
  for (const auto& [cause, cells] : score.causes) {
    names[cause] = cause == kCauseEdge    ? "an edge"
                   : cause == kCauseSlope ? "a slope"
                   : table                ? table->name(cause)
                                          : "class " + std::to_string(cause);
  }
  return names;
}

Laying layingOf(const Evaluation& evaluation) {
  return Laying(evaluation.trajectory ? evaluation.trajectory->T_truth_map : Pose::Identity());
}

/// An error line, empty when done, also where no grid was given.
std::string scoreGrid(const EvalOptions& options, Evaluation& evaluation) {
  if (options.grid.empty()) {
    return "";
  }
  const auto map = readMapGrid(options.grid);
  const auto truth = readWalkGrid(options.truth);
  const auto poses = readPoses(options.poses.empty() ? options.truth / "poses.txt" : options.poses);
  if (!map || !truth || !poses) {
    return !map ? map.error : !truth ? truth.error : poses.error;
  }
  evaluation.grid = GridScore{scoreWalk(*map, *truth, layingOf(evaluation), *poses), std::nullopt, {}};
  evaluation.grid->names = namesOf(evaluation.grid->whole, options.truth);
  if (evaluation.scenery.corrected) {
    evaluation.grid->local = scoreWalk(*map, *truth, Laying(evaluation.scenery.corrected->pairs), *poses);
  }
  return "";
}

/// Draws pairs to plan between, or scores the answers to those drawn before; an error line, empty when done.
std::string handlePlans(const EvalOptions& options, Evaluation& evaluation) {
  if (options.plans == 0 && options.plan_answers.empty()) {
    return "";
  }
  const auto truth = readWalkGrid(options.truth);
  if (!truth) {
    return truth.error;
  }
  if (options.plans > 0) {
    constexpr std::uint64_t kSeed = 1;
    return writePlanRequests(drawPlans(*truth, {}, layingOf(evaluation), options.plans, kSeed), options.plan_requests);
  }
  const auto requests = readPlanRequests(options.plan_requests);
  const auto answers = readPlanAnswers(options.plan_answers);
  if (!requests || !answers) {
    return !requests ? requests.error : answers.error;
  }
  if (requests->size() != answers->size()) {
    return options.plan_answers.string() + ": " + std::to_string(answers->size()) + " answers to " +
           std::to_string(requests->size()) + " requests";
  }
  evaluation.plans = scorePlans(*requests, *answers, *truth, layingOf(evaluation));
  return "";
}

/// Reads map and truth and matches their objects; an error line, empty when done.
std::string scoreObjects(const EvalOptions& options, Evaluation& evaluation) {
  auto graph = options.map.empty() ? readGraphJson(options.graph) : readMapObjects(options.map);
  auto truth = readTruthObjects(options.truth / "gt_objects.json");
  if (!graph || !truth) {
    return !graph ? graph.error : truth.error;
  }
  const auto only = findClasses(options.classes, graph->class_names);
  if (!only) {
    return only.error;
  }
  Pose T_truth_first = Pose::Identity(), T_beliefs = Pose::Identity();
  if (evaluation.trajectory) {
    T_truth_first = evaluation.trajectory->T_truth_first;
    T_beliefs = T_truth_first * evaluation.trajectory->T_truth_map.inverse();
    for (MappedObject& object : graph->objects) {
      object = transform(evaluation.trajectory->T_truth_map, object);
    }
  }
  markThings(graph->objects, *truth);
  evaluation.class_names = std::move(graph->class_names);
  evaluation.objects = evaluateObjects(graph->objects, *truth, options.radius, *only, T_beliefs);
  if (const auto path = givenOr({}, options.truth / "rooms.json"); !path.empty()) {
    const auto rooms = readRooms(path);
    if (!rooms) {
      return rooms.error;
    }
    evaluation.rooms = scoreRooms(evaluation.objects.overall.matches, *truth, *rooms, graph->region_of);
  }
  if (graph->map != nullptr) {
    evaluation.neighbours = relativeCalibration(*graph->map, evaluation.objects.overall.matches, *truth,
                                                T_truth_first.linear(), kNeighbourReach);
  }
  evaluation.scenery.predictions = std::move(graph->objects);
  evaluation.scenery.truth = std::move(*truth);
  return "";
}

/// The frames of these times, when every true pose has its pair; empty when one has none.
std::vector<std::int64_t> framesAt(std::span<const PosePair> pairs, const std::vector<Micros>& times_us) {
  std::vector<std::int64_t> frames;
  for (const Micros time_us : times_us) {
    const auto at = indexAt(pairs, time_us);
    if (!at) {
      return {};
    }
    frames.push_back(static_cast<std::int64_t>(*at));
  }
  return frames;
}

/// What moves, as the run told of it, else as the graph says; an error line, empty when done.
std::string judgeMoving(const EvalOptions& options, const std::vector<MappedObject>& asked, Evaluation& evaluation) {
  const Scenery& scenery = evaluation.scenery;
  const auto path = options.map.empty() ? options.map : givenOr({}, options.map.parent_path() / kMovingName);
  if (path.empty()) {
    evaluation.moving = scoreMoving(asked, scenery.truth, options.radius);
    return "";
  }
  auto told = readMoving(path);
  if (!told) {
    return told.error;
  }
  if (!options.classes.empty()) {
    std::erase_if(*told, [&](const ToldMover& m) { return !evaluation.objects.classes.contains(m.label); });
  }
  const Pose T_truth_map = evaluation.trajectory ? evaluation.trajectory->T_truth_map : Pose::Identity();
  for (ToldMover& mover : *told) {
    for (Vec3& p : mover.places) {
      p = T_truth_map * p;
    }
    mover.frames = evaluation.trajectory && evaluation.trajectory->share == 1
                       ? framesAt(scenery.corrected->pairs, mover.times_us)
                       : std::vector<std::int64_t>();
  }
  evaluation.moving = scoreMoving(*told, scenery.truth, options.radius);
  return "";
}

/// Looks for twins and for what ghosts come from; an error line, empty when done.
std::string explainObjects(const EvalOptions& options, Evaluation& evaluation) {
  const Scenery& scenery = evaluation.scenery;
  std::vector<MappedObject> asked = scenery.predictions;
  std::erase_if(asked, [&](const MappedObject& p) { return !evaluation.objects.classes.contains(p.label); });
  if (std::string error = judgeMoving(options, asked, evaluation); !error.empty()) {
    return error;
  }
  evaluation.twins = findTwins(asked, scenery.truth, options.radius);
  std::vector<CloudPoint> cloud;
  const auto path = givenOr({}, options.truth / "cloud.ply");
  if (!path.empty() && !evaluation.objects.overall.ghosts.empty()) {
    auto read = readCloud(path);
    if (!read) {
      return read.error;
    }
    cloud = std::move(*read);
  }
  evaluation.ghosts = explainGhosts(scenery.predictions, scenery.truth, evaluation.objects, cloud, options.radius);
  return "";
}

}  // namespace

Result<Evaluation> evaluate(const EvalOptions& options) {
  Evaluation evaluation;
  evaluation.radius = options.radius;
  for (auto* step : {scorePaths, scoreObjects, explainObjects, scoreGeometry, scoreAnswers, readCost, scoreLoopsOfRun,
                     scoreGrid, handlePlans}) {
    if (const std::string error = step(options, evaluation); !error.empty()) {
      return Result<Evaluation>::fail(error);
    }
  }
  return Result<Evaluation>::ok(std::move(evaluation));
}

}  // namespace hgg
