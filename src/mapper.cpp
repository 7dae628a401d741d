#include "mapper.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "alignment/align.h"
#include "alignment/propagation.h"
#include "alignment/recovery.h"
#include "core/se3.h"
#include "core/units.h"
#include "creation/object_graph.h"
#include "map/class_evidence.h"
#include "map/fuse.h"
#include "map/same_thing.h"

namespace hgg {
namespace {

/// Times consecutive stages of a step.
class StageClock {
 public:
  explicit StageClock(std::vector<std::pair<std::string, double>>& stage_ms) : stage_ms_(stage_ms) {}
  void lap(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    stage_ms_.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
    last_ = now;
  }

 private:
  std::vector<std::pair<std::string, double>>& stage_ms_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Beams of a frame that its range image takes, at least half as many where it has more: bounds the work.
constexpr std::size_t kImageBeams = 60'000;
/// How well an aligned frame's turn is known at best, rad; what alignment reports is surer than frames are
/// (docs/method.md, "A prior that is too sure").
constexpr double kTurnFloor = 0.05 * kDegree;

/// Each how many points the image takes one.
std::size_t strideOf(const Frame& frame) { return std::max<std::size_t>(frame.points.size() / kImageBeams, 1); }

/// What the frame sees through from its aligned pose.
std::shared_ptr<FreeSpace> freeSpaceOf(const Frame& frame, const Alignment& alignment) {
  const Pose& T_map_body = alignment.pose.T_map_body;
  auto shared = std::make_shared<FreeSpace>(
      FreeSpace{RangeImage(frame.p_body_sensor), T_map_body * Eigen::Translation3d(frame.p_body_sensor)});
  FreeSpace& free = *shared;
  const std::size_t stride = strideOf(frame);
  for (std::size_t k = 0; k < frame.points.size(); k += stride) {
    free.image.add(frame.points[k].x, frame.points[k].y, frame.points[k].z);
  }
  const Mat6 cov = alignment.pose.information.inverse();
  free.variance = std::max(cov.topLeftCorner<3, 3>().trace() / 3, 0.0);
  free.variance_turn = std::max(cov.bottomRightCorner<3, 3>().trace() / 3, 0.0) + square(kTurnFloor);
  return shared;
}

/// The nodes that the frame has as things of their own, ascending.
std::vector<NodeId> foundIn(const Alignment& alignment) {
  std::vector<NodeId> found;
  for (const ObjectPair& pair : alignment.pairs) {
    found.push_back(pair.map);
  }
  std::ranges::sort(found);
  return found;
}

/// Names of the table's classes, beside those the map has from before.
std::map<ClassId, std::string> namesOf(const ClassTable& classes, std::map<ClassId, std::string> names) {
  for (const ClassInfo& info : classes.classes()) {
    names[info.id] = info.name;
  }
  return names;
}

}  // namespace

std::string explainMismatch(const Map& map, const Config& config, const ClassTable& classes) {
  if (map.tileSize() != config.creation.tile_size) {
    return fmt::format("the map has tiles of {} m, the config of {} m: set creation.tile_size to go on from it",
                       map.tileSize(), config.creation.tile_size);
  }
  for (const auto& [id, node] : map.nodes()) {
    const ClassInfo* info = classes.find(node.label);
    if (info != nullptr && (info->kind == ClassKind::kStuff) != node.stuff) {
      return fmt::format("'{}' is {} in the map and not in the class table: go on with the table it was made with",
                         info->name, node.stuff ? "stuff" : "a thing");
    }
  }
  return {};
}

Mapper::Mapper(Config config, ClassTable classes, Map map, LoopTiming timing, PageStore pages)
    : config_(std::move(config)),
      classes_(std::move(classes)),
      map_(std::move(map)),
      corrector_(config_, classes_, timing, std::move(pages)) {
  map_.setClassNames(namesOf(classes_, map_.classNames()));
  map_.setTileSize(config_.creation.tile_size);
  map_.setEdgeModel({config_.creation.sigma_floor, config_.creation.edge_geometry_share});
  corrector_.start(map_);
  if (config_.correction.loop_closure) {
    map_.setDriftReach(config_.correction.drift_reach);
  }
}

StepReport Mapper::step(const Frame& frame) {
  StepReport report;
  StageClock clock(report.stage_ms);
  const Prediction prediction = propagate(frame, report.delta);
  if (prediction.is_start) {
    report.stopped = forgetMovers(movers_);
  }
  const Pose& T_predicted = prediction.pose.T_map_body;
  LocalGraph local = createLocalGraph(frame, T_predicted, classes_, config_);
  std::vector<ObjectPair> none;
  std::vector<LocalObject> taken = takeMoving(movers_, local, none, T_predicted, classes_);
  clock.lap("creation");
  Alignment alignment = align(local, map_, prediction.pose, config_);
  report.tracking = track(frame, prediction, local, alignment, taken);
  clock.lap("alignment");
  if (report.tracking == Tracking::kDoubtful) {  // nothing of a frame in the wrong place may enter the map
    report.tracking = tracker_.hold(frame, prediction);
  } else {
    const bool is_jump = (prediction.is_start && !prediction.is_unknown) || report.tracking == Tracking::kRecovered;
    report.T_last_body = tracker_.motionTo(alignment.pose.T_map_body);
    const Pose T_last_body = report.T_last_body.value_or(Pose::Identity());
    const KeyframeDecision keyframe = corrector_.decideKeyframe(map_, local, alignment, T_last_body, is_jump,
                                                                tracker_.odometry().noiseOf(T_last_body));
    const std::shared_ptr<FreeSpace> free = freeSpaceOf(frame, alignment);
    keepViews(alignment.pairs, map_, local, alignment.pose.T_map_body, classes_, config_);
    MapDelta updated = follow(free, local, alignment, taken, report);
    free->found = foundIn(alignment);
    clock.lap("movers");
    updated = joined(std::move(updated), update(frame, local, alignment, *free, keyframe));
    clock.lap("update");
    const int loops_before = corrector_.loops().accepted();
    Correction correction = corrector_.correct(map_, std::move(updated), keyframe, local, alignment);
    clock.lap("correction");
    tracker_.accept(frame, alignment, alignment.pose, config_.alignment);
    tracker_.moveTo(correction.pose);
    if (correction.pose.T_map_body.matrix() != alignment.pose.T_map_body.matrix()) {
      moveAlong(movers_, correction.pose.T_map_body * alignment.pose.T_map_body.inverse());
    }
    followFragment(loops_before);
    report.delta = joined(std::move(report.delta), correction.delta);
    T_map_odom_ = correction.pose.T_map_body * frame.T_odom_body.inverse();
  }
  report.moving = moversOf(movers_);
  report.utime_us = frame.utime_us;
  report.points = local.points.size();
  report.unknown_labels = local.unknown_labels;
  report.nonfinite_points = local.nonfinite_points;
  describePose(alignment, report);
  return report;
}

Prediction Mapper::propagate(const Frame& frame, MapDelta& delta) {
  Prediction prediction = tracker_.predict(frame, config_.alignment);
  prediction.is_unknown |= prediction.is_start && !map_.keyframes().poses().empty() && !T_map_start_;
  if (prediction.is_start) {
    const Pose T_map_body = T_map_start_.value_or(T_map_odom_ * frame.T_odom_body);
    prediction.pose = startPose(T_map_body, map_.nodes().empty());
    map_.startAt(map_.keyframes().newestAt(T_map_body.translation()));
  }
  if (prediction.is_unknown) {
    prediction.pose = startPose(prediction.pose.T_map_body, corrector_.canJoinFragments());
    delta = corrector_.beginFragment(map_, frame.utime_us, prediction.pose.T_map_body);
    fragment_ = corrector_.canJoinFragments() ? map_.keyframes().last() : fragment_;
    prediction.is_start = true;
  }
  if (prediction.is_start) {
    tracker_.startAt(frame, prediction.pose);
  }
  const Vec3 here = prediction.pose.T_map_body.translation();
  delta = joined(std::move(delta), corrector_.bringBackAround(map_, here));
  if (prediction.is_start) {
    delta = joined(std::move(delta), corrector_.makeRoom(map_, here, std::numeric_limits<std::size_t>::max()));
  }
  return prediction;
}

Tracking Mapper::track(const Frame& frame, const Prediction& prediction, LocalGraph& local, Alignment& alignment,
                       std::vector<LocalObject>& taken) {
  if (prediction.is_start) {
    return Tracking::kHeld;
  }
  if (prediction.is_disputed) {
    Recovery other = alignFrom(prediction.guesses.back(), frame, map_, classes_, config_);
    if (fitsClearlyBetter(other.alignment.fit, alignment.fit)) {
      local = std::move(other.local), alignment = std::move(other.alignment);
      taken.clear();
    }
  }
  const Tracking judged = tracker_.judge(prediction, alignment);
  const bool can_prove = prediction.is_unproven && UsualFit::canTell(alignment.fit);
  if (judged == Tracking::kHeld && !can_prove) {
    return judged;
  }
  const SearchReach reach = tracker_.reach(config_.map.leaf_size);
  if (judged == Tracking::kHeld && isFoundAt(alignment.pose.T_map_body, local, map_, reach, config_)) {
    tracker_.proveOdometry();
    return judged;
  }
  auto found = recover(frame, map_, prediction.guesses, reach, tracker_.leastShare(), classes_, config_);
  if (!found || (judged == Tracking::kHeld && !fitsClearlyBetter(found->alignment.fit, alignment.fit))) {
    if (found && !areDistinctPoses(found->alignment.pose.T_map_body, alignment.pose.T_map_body)) {
      tracker_.proveOdometry();
    }
    return judged;
  }
  local = std::move(found->local), alignment = std::move(found->alignment);
  taken.clear();
  return Tracking::kRecovered;
}

MapDelta Mapper::follow(const std::shared_ptr<const FreeSpace>& free, LocalGraph& local, Alignment& alignment,
                        const std::vector<LocalObject>& taken, StepReport& report) {
  if (config_.ablation.blind_to_motion) {
    return {};
  }
  if (report.tracking == Tracking::kRecovered) {
    report.stopped = forgetMovers(movers_);
  }
  Followed followed =
      followMovers(movers_, local, alignment.pairs, taken, alignment.pose.T_map_body, free, classes_, map_);
  report.stopped.insert(report.stopped.end(), followed.ended.begin(), followed.ended.end());
  if (followed.trail.empty()) {
    return {};
  }
  MapUpdate update;
  update.is_sequel = true;
  update.removed = std::move(followed.trail);
  return map_.apply(std::move(update));
}

MapDelta Mapper::update(const Frame& frame, const LocalGraph& local, const Alignment& alignment, const FreeSpace& free,
                        const KeyframeDecision& keyframe) {
  const Pose& T_map_body = alignment.pose.T_map_body;
  const std::optional<Pose> T_last_body = tracker_.motionTo(T_map_body);
  const double weight = T_last_body ? viewWeight(*T_last_body) : 1;
  SmallThings small;
  if (!config_.ablation.single_frames) {
    small = gatherSmallThings(map_, local, {free.image, free.T_map_sensor, static_cast<double>(strideOf(frame))},
                              T_map_body, weight, classes_, config_);
  }
  const auto evidence =
      classEvidence(local, map_, T_map_body, weight, config_.map.active_radius, config_.creation.sigma_floor,
                    config_.ablation.blind_to_free_space ? nullptr : &free);
  MapUpdate update = fuse(map_, local, T_map_body, alignment.pairs, evidence, classes_, config_, std::move(small));
  update.keyframe = keyframe.added;
  update.taken_up = keyframe.taken_up;
  MapDelta delta = map_.apply(std::move(update));
  noteFedNodes(movers_, map_);
  return delta;
}

void Mapper::followFragment(int loops_before) {
  if (fragment_ != 0 && corrector_.loops().accepted() != loops_before) {
    fragment_ = map_.keyframes().fragments().back();
  }
}

void Mapper::describePose(const Alignment& alignment, StepReport& report) const {
  report.T_map_body = tracker_.pose().T_map_body;
  report.T_map_odom = T_map_odom_;
  report.keyframe = map_.keyframes().current();
  report.T_keyframe_body = map_.keyframes().currentPose().T_map_body.inverse() * report.T_map_body;
  report.source = report.tracking == Tracking::kDoubtful || report.tracking == Tracking::kLost ? PoseSource::kOdometry
                                                                                               : alignment.source;
  report.odometry_fault = tracker_.odometryFault();
  report.fragment = fragment_;
  report.pose_cov = tracker_.pose().information.inverse();
  report.degenerate = static_cast<int>(alignment.degenerate_directions.size());
  report.paging_trouble = corrector_.pages().trouble ? corrector_.pages().trouble() : "";
}

void Mapper::finish() {
  const Correction correction = corrector_.finish(map_, tracker_.hasStarted() ? tracker_.pose() : PoseBelief{});
  if (tracker_.hasStarted()) {
    tracker_.moveTo(correction.pose);
  }
  map_.settleGraph();
}

}  // namespace hgg
