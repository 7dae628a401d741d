#include "correction/corrector.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/se3.h"
#include "map/fuse.h"

namespace hgg {
namespace {

/// Nodes that are merged with what they lie on in one go: a few milliseconds' work.
constexpr std::size_t kMostMerged = 200;

/// What was done first and then, as one change. Each node is named once: as removed before as changed, and as changed
/// before as moved.
MapDelta joined(MapDelta first, const MapDelta& second) {
  if (second.revision == 0) {
    return first;
  }
  MapDelta both;
  both.revision = second.revision;
  std::ranges::set_union(first.changed, second.changed, std::back_inserter(both.changed));
  std::ranges::set_union(first.moved, second.moved, std::back_inserter(both.moved));
  std::ranges::set_union(first.removed, second.removed, std::back_inserter(both.removed));
  const auto isRemoved = [&](NodeId id) { return std::ranges::binary_search(both.removed, id); };
  std::erase_if(both.changed, isRemoved);
  std::erase_if(both.moved, [&](NodeId id) { return isRemoved(id) || std::ranges::binary_search(both.changed, id); });
  return both;
}

/// The belief after the map frame's part around it has been moved by a rigid transform.
PoseBelief moved(const Pose& move, const PoseBelief& pose) {
  Mat6 rotation = Mat6::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = move.linear();
  return {orthonormalized(move * pose.T_map_body), rotation * pose.information * rotation.transpose()};
}

}  // namespace

Corrector::Corrector(const Config& config, const ClassTable& classes, LoopTiming timing)
    : config_(config),
      classes_(classes),
      loops_(loopConfigOf(config.creation.tile_size, config.map.leaf_size), classes.similar(), timing) {}

void Corrector::start(const Map& stored) {
  if (config_.correction.loop_closure) {
    loops_.start(stored);
  }
}

std::optional<NewKeyframe> Corrector::decideKeyframe(const Map& map, const LocalGraph& local,
                                                     const Alignment& alignment, const Pose& T_last_body,
                                                     bool is_jump) {
  const double leaf_size = config_.map.leaf_size;
  const Pose& T_map_body = alignment.pose.T_map_body;
  ++frames_;
  travel_ = propagateTravel(travel_, T_last_body, alignment, is_jump, config_.alignment, leaf_size);
  if (!map.keyframes().needsOne(T_map_body)) {
    return std::nullopt;
  }
  const Travel travel = std::exchange(travel_, {});
  return NewKeyframe{{local.utime_us, T_map_body},
                     betweenConstraints(T_map_body, map, local, alignment, travel, leaf_size)};
}

Correction Corrector::correct(Map& map, MapDelta updated, bool is_keyframe, const LocalGraph& local,
                              const Alignment& alignment) {
  Correction correction{updated, alignment.pose};
  mergePending(map, updated, correction);
  if (!is_keyframe) {
    return correction;
  }
  if (config_.correction.window) {
    refinePoses(map, local, alignment, correction);
  }
  if (config_.correction.em) {
    refineLeaves(map, local, alignment, correction);
  }
  if (config_.correction.loop_closure) {
    if (const auto loop = loops_.step(map)) {
      apply(map, *loop, correction);
    }
  }
  frames_ = 0;
  return correction;
}

Correction Corrector::finish(Map& map, const PoseBelief& pose) {
  Correction correction{{}, pose};
  if (const auto loop = loops_.finish(map)) {
    apply(map, *loop, correction);
  }
  while (!pending_merges_.empty()) {
    mergePending(map, {}, correction);
  }
  return correction;
}

void Corrector::refinePoses(Map& map, const LocalGraph& local, const Alignment& alignment, Correction& correction) {
  WindowConfig window;
  window.sigma_floor = config_.creation.sigma_floor;
  window.noise.uniform_weights = config_.ablation.uniform_weights;
  pose_window_.add(map, map.keyframes().last(), local, alignment);
  if (const auto moves = pose_window_.solve(map, config_.map.leaf_size, window)) {
    apply(map, *moves, correction);
  }
}

void Corrector::refineLeaves(Map& map, const LocalGraph& local, const Alignment& alignment, Correction& correction) {
  geometry_window_.add(map.keyframes().last(), local, alignment.pairs, frames_, config_.correction.em_points);
  MapUpdate refined;
  refined.is_sequel = true;
  refined.changed = geometry_window_.refine(map, config_.creation.sigma_floor);
  correction.delta = joined(std::move(correction.delta), map.apply(std::move(refined)));
}

void Corrector::apply(Map& map, const MapCorrection& moves, Correction& correction) {
  const Pose T_map_keyframe = map.keyframes().poses().back().T_map_body;
  const MapDelta delta = map.apply(moves);
  correction.delta = joined(std::move(correction.delta), delta);
  mergePending(map, delta, correction);
  const Pose move = orthonormalized(map.keyframes().poses().back().T_map_body * T_map_keyframe.inverse());
  correction.pose = moved(move, correction.pose);
}

void Corrector::mergePending(Map& map, const MapDelta& delta, Correction& correction) {
  std::vector<NodeId> found, waiting;
  std::ranges::set_union(delta.reactivated, delta.colliding, std::back_inserter(found));
  std::ranges::set_union(pending_merges_, found, std::back_inserter(waiting));
  if (waiting.empty()) {
    return;
  }
  const auto rest = waiting.begin() + static_cast<std::ptrdiff_t>(std::min(waiting.size(), kMostMerged));
  pending_merges_.assign(rest, waiting.end());
  waiting.erase(rest, waiting.end());
  MapUpdate merged = mergeDuplicates(map, waiting, classes_, config_);
  correction.delta = joined(std::move(correction.delta), map.apply(std::move(merged)));
}

}  // namespace hgg
