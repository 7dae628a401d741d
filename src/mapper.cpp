#include "mapper.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
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
  const std::optional<PoseBelief> propagated = propagate(frame.T_odom_body);
  const PoseBelief prior = propagated ? *propagated : start(frame.T_odom_body);
  const MapDelta back = corrector_.bringBackAround(map_, prior.T_map_body.translation());

  const LocalGraph local = createLocalGraph(frame, prior.T_map_body, classes_, config_);
  clock.lap("creation");
  const Alignment alignment = align(local, map_, prior, config_);
  clock.lap("alignment");
  const Pose T_last_body =
      last_ ? Pose(last_->pose.T_map_body.inverse() * alignment.pose.T_map_body) : Pose::Identity();
  const auto keyframe = corrector_.decideKeyframe(map_, local, alignment, T_last_body, !propagated);
  MapDelta updated = update(local, alignment, T_last_body, keyframe);
  clock.lap("update");
  Correction correction = corrector_.correct(map_, std::move(updated), keyframe.has_value(), local, alignment);
  clock.lap("correction");

  last_ = {correction.pose, frame.T_odom_body};
  T_map_odom_ = correction.pose.T_map_body * frame.T_odom_body.inverse();
  report.utime_us = frame.utime_us;
  report.delta = joined(back, correction.delta);
  report.points = local.points.size();
  report.unknown_labels = local.unknown_labels;
  report.nonfinite_points = local.nonfinite_points;
  describePose(alignment, report);
  return report;
}

std::optional<PoseBelief> Mapper::propagate(const Pose& T_odom_body) const {
  return last_ ? propagatePose(last_->pose, last_->T_odom_body.inverse() * T_odom_body, config_.alignment)
               : std::nullopt;
}

PoseBelief Mapper::start(const Pose& T_odom_body) {
  PoseBelief pose = startPose(T_map_odom_ * T_odom_body, map_.nodes().empty());
  if (!last_) {
    map_.startAt(map_.keyframes().newestAt(pose.T_map_body.translation()));
  }
  return pose;
}

MapDelta Mapper::update(const LocalGraph& local, const Alignment& alignment, const Pose& T_last_body,
                        const std::optional<NewKeyframe>& keyframe) {
  const Pose& T_map_body = alignment.pose.T_map_body;
  const auto evidence = classEvidence(local, map_, T_map_body, last_ ? viewWeight(T_last_body) : 1,
                                      config_.map.active_radius, config_.creation.sigma_floor);
  MapUpdate update = fuse(map_, local, T_map_body, alignment.pairs, evidence, classes_, config_);
  update.keyframe = keyframe;
  return map_.apply(std::move(update));
}

void Mapper::describePose(const Alignment& alignment, StepReport& report) const {
  report.T_map_body = last_->pose.T_map_body;
  report.T_map_odom = T_map_odom_;
  report.keyframe = map_.keyframes().last();
  report.T_keyframe_body = map_.keyframes().poses().back().T_map_body.inverse() * report.T_map_body;
  report.source = alignment.source;
  report.degenerate = static_cast<int>(alignment.degenerate_directions.size());
}

void Mapper::finish() {
  const Correction correction = corrector_.finish(map_, last_ ? last_->pose : PoseBelief{});
  if (last_) {
    last_->pose = correction.pose;
  }
  map_.settleGraph();
}

}  // namespace hgg
