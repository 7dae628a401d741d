#include "mapper.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <utility>

#include "alignment/align.h"
#include "alignment/propagation.h"
#include "core/se3.h"
#include "creation/object_graph.h"
#include "map/class_evidence.h"
#include "map/fuse.h"

namespace hgg {
namespace {

/// Nodes that are merged with what they lie on at once, a few milliseconds' work.
constexpr std::size_t kMostMerged = 200;

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

/// Names of the table's classes, beside those the map has from before.
std::map<ClassId, std::string> namesOf(const ClassTable& classes, std::map<ClassId, std::string> names) {
  for (const ClassInfo& info : classes.classes()) {
    names[info.id] = info.name;
  }
  return names;
}

/// What one step did first and then, as one. A node is named once: as removed before as changed before as moved before
/// as rewired, whichever came first.
MapDelta joined(MapDelta first, MapDelta second) {
  if (second.revision == 0) {
    return first;
  }
  MapDelta both;
  both.revision = second.revision;
  std::ranges::set_union(first.changed, second.changed, std::back_inserter(both.changed));
  std::ranges::set_union(first.moved, second.moved, std::back_inserter(both.moved));
  std::ranges::set_union(first.removed, second.removed, std::back_inserter(both.removed));
  std::ranges::set_union(first.rewired, second.rewired, std::back_inserter(both.rewired));
  const auto isRemoved = [&](NodeId id) { return std::ranges::binary_search(both.removed, id); };
  std::erase_if(both.changed, isRemoved);
  const auto isChanged = [&](NodeId id) { return isRemoved(id) || std::ranges::binary_search(both.changed, id); };
  std::erase_if(both.moved, isChanged);
  std::erase_if(both.rewired, [&](NodeId id) { return isChanged(id) || std::ranges::binary_search(both.moved, id); });
  return both;
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

Mapper::Mapper(Config config, ClassTable classes, Map map, LoopTiming timing)
    : config_(std::move(config)),
      classes_(std::move(classes)),
      map_(std::move(map)),
      loops_(config_, classes_.similar(), timing) {
  map_.setClassNames(namesOf(classes_, map_.classNames()));
  map_.setTileSize(config_.creation.tile_size);
  map_.setEdgeModel({config_.creation.sigma_floor, config_.creation.edge_geometry_share});
  if (config_.correction.loop_closure) {
    loops_.start(map_);
    map_.setDriftReach(config_.correction.drift_reach);
  }
}

std::optional<PoseBelief> Mapper::predict(const Pose& T_odom_body) const {
  return last_ ? propagatePose(last_->pose, last_->T_odom_body.inverse() * T_odom_body, config_.alignment)
               : std::nullopt;
}

StepReport Mapper::step(const Frame& frame) {
  StepReport report;
  StageClock clock(report.stage_ms);
  const auto predicted = predict(frame.T_odom_body);
  const PoseBelief prior = predicted.value_or(startPose(T_map_odom_ * frame.T_odom_body, map_.nodes().empty()));
  if (!last_) {
    map_.startAt(map_.keyframes().newestAt(prior.T_map_body.translation()));
  }

  const LocalGraph local = createLocalGraph(frame, prior.T_map_body, classes_, config_);
  clock.lap("creation");
  const Alignment alignment = align(local, map_, prior, config_);
  clock.lap("alignment");
  const KeyframeId keyframe = map_.keyframes().last();
  report.delta = update(frame, local, alignment, !predicted);
  clock.lap("update");
  if (map_.keyframes().last() != keyframe) {
    report.delta = joined(std::move(report.delta), correct(local, alignment));
  }
  clock.lap("correction");

  T_map_odom_ = last_->pose.T_map_body * frame.T_odom_body.inverse();
  report.utime_us = frame.utime_us;
  report.T_map_body = last_->pose.T_map_body;
  report.keyframe = map_.keyframes().last();
  report.T_keyframe_body = map_.keyframes().poses().back().T_map_body.inverse() * report.T_map_body;
  report.source = alignment.source;
  report.degenerate = static_cast<int>(alignment.degenerate_directions.size());
  report.T_map_odom = T_map_odom_;
  report.points = local.points.size();
  report.unknown_labels = local.unknown_labels;
  report.nonfinite_points = local.nonfinite_points;
  return report;
}

void Mapper::finish() {
  if (const auto correction = loops_.finish(map_)) {
    carryOut(*correction);
  }
  while (!pending_merges_.empty()) {
    mergePending({});
  }
  map_.settleGraph();
}

MapDelta Mapper::update(const Frame& frame, const LocalGraph& local, const Alignment& alignment, bool is_jump) {
  const Pose& T_map_body = alignment.pose.T_map_body;
  const Pose T_last_body = last_ ? Pose(last_->pose.T_map_body.inverse() * T_map_body) : Pose::Identity();
  const auto evidence = classEvidence(local, map_, T_map_body, last_ ? viewWeight(T_last_body) : 1, config_);
  MapUpdate update = fuse(map_, local, T_map_body, alignment.pairs, evidence, classes_, config_);
  ++frames_;
  travel_ = travelOn(travel_, T_last_body, alignment, is_jump, config_);
  if (map_.keyframes().needsOne(T_map_body)) {
    update.constraints = betweenConstraints(T_map_body, map_, local, alignment, travel_, config_);
    travel_ = {};
  }
  last_ = {alignment.pose, frame.T_odom_body};
  return mergePending(map_.apply(std::move(update)));
}

MapDelta Mapper::correct(const LocalGraph& local, const Alignment& alignment) {
  MapDelta delta;
  const int frames = std::exchange(frames_, 0);
  if (config_.correction.window) {
    pose_window_.add(map_, map_.keyframes().last(), local, alignment);
    if (const auto correction = pose_window_.solve(map_, config_)) {
      delta = carryOut(*correction);
    }
  }
  if (config_.correction.em) {
    geometry_window_.add(map_.keyframes().last(), local, alignment.pairs, frames, config_);
    MapUpdate refined;
    refined.is_sequel = true;
    refined.pose = map_.keyframes().poses().back();
    refined.changed = geometry_window_.refine(map_, config_);
    delta = joined(std::move(delta), map_.apply(std::move(refined)));
  }
  if (config_.correction.loop_closure) {
    if (const auto correction = loops_.step(map_)) {
      delta = joined(std::move(delta), carryOut(*correction));
    }
  }
  return delta;
}

MapDelta Mapper::mergePending(MapDelta delta) {
  std::vector<NodeId> found, waiting;
  std::ranges::set_union(delta.reactivated, delta.colliding, std::back_inserter(found));
  std::ranges::set_union(pending_merges_, found, std::back_inserter(waiting));
  if (waiting.empty()) {
    return delta;
  }
  const auto rest = waiting.begin() + static_cast<std::ptrdiff_t>(std::min(waiting.size(), kMostMerged));
  pending_merges_.assign(rest, waiting.end());
  waiting.erase(rest, waiting.end());
  MapUpdate merged = mergeDuplicates(map_, waiting, classes_, config_);
  return joined(std::move(delta), map_.apply(std::move(merged)));
}

MapDelta Mapper::carryOut(const MapCorrection& correction) {
  const Pose T_map_keyframe = map_.keyframes().poses().back().T_map_body;
  MapDelta delta = mergePending(map_.apply(correction));
  const Pose move = orthonormalized(map_.keyframes().poses().back().T_map_body * T_map_keyframe.inverse());
  PoseBelief& pose = last_->pose;
  pose.T_map_body = orthonormalized(move * pose.T_map_body);
  Mat6 turn = Mat6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = move.linear();
  pose.information = turn * pose.information * turn.transpose();
  return delta;
}

}  // namespace hgg
