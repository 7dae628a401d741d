#include "correction/corrector.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "core/se3.h"
#include "map/fuse.h"
#include "map/second_nodes.h"

namespace hgg {
namespace {

/// Nodes that are merged with what they lie on in one go: a few milliseconds' work.
constexpr std::size_t kMostMerged = 200;
/// Pages leave only from this many times the distance at which they are brought back, so that none goes to and fro, and
/// what the sliding windows still use stays.
constexpr double kKeepMargin = 1.5;
/// A keyframe is taken up again while the way since the last one is known this much better than parts of the map that
/// are matched have to be.
constexpr double kHeldShare = 0.5;
/// Pages that lie so much beyond what is brought back are read ahead, m: several frames' way.
constexpr double kReadAhead = 20;
/// Pages that leave at one keyframe at most: a millisecond's work.
constexpr std::size_t kMostLeaving = 6;

/// The belief after the map frame's part around it has been moved by a rigid transform.
PoseBelief moved(const Pose& move, PoseBelief pose) {
  Mat6 rotation = Mat6::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = move.linear();
  pose.T_map_body = orthonormalized(move * pose.T_map_body);
  pose.information = rotation * pose.information * rotation.transpose();
  return pose;
}

}  // namespace

Corrector::Corrector(const Config& config, const ClassTable& classes, LoopTiming timing, PageStore pages)
    : config_(config),
      classes_(classes),
      pages_(std::move(pages)),
      loops_(loopConfigOf(config.creation.tile_size, config.map.leaf_size, config.alignment.gate), classes.similar(),
             timing) {
  pages_.keep_radius = std::max(pages_.keep_radius, kKeepMargin * residentRadius());
}

void Corrector::start(const Map& stored) {
  if (config_.correction.loop_closure) {
    loops_.start(stored);
  }
}

/// Farthest that the means of two nodes which become one are apart: things pair within the gate, and the means of a
/// tile's nodes lie in the tile.
double Corrector::mergeDistance() const {
  return std::max(config_.alignment.gate, std::numbers::sqrt3 * config_.creation.tile_size);
}

/// What a frame, a loop or a merge reads around the robot: a frame's points and the things it may pair with, and the
/// place that verification compares.
double Corrector::residentRadius() const {
  return std::max({config_.map.active_radius, config_.frame.range_max, loops_.placeRadius()}) + mergeDistance();
}

MapDelta Corrector::bringBackAround(Map& map, const Vec3& p_map) {
  MapDelta delta = bringBack(map, pages_, p_map, residentRadius());
  notePending(delta);
  if (pages_.prefetch) {
    pages_.prefetch(map.pagedOutNear(p_map, residentRadius() + kReadAhead));
  }
  return delta;
}

MapDelta Corrector::makeRoom(Map& map, const Vec3& p_map, std::size_t most) {
  if (!pages_.isOpen()) {
    return {};
  }
  if (!pages_.has_room || pages_.has_room()) {
    return pageOutBeyond(map, pages_, p_map, pending_merges_, most);
  }
  // What merely waits for the disk makes room soon.
  return !pages_.is_failing || pages_.is_failing()
             ? dropDetailBeyond(map, pages_, p_map, pending_merges_, config_.map.leaf_size, most)
             : MapDelta{};
}

KeyframeDecision Corrector::decideKeyframe(const Map& map, const LocalGraph& local, const Alignment& alignment,
                                           const Pose& T_last_body, bool is_jump, const NoiseScale& odometry) {
  const double leaf_size = config_.map.leaf_size;
  const Pose& T_map_body = alignment.pose.T_map_body;
  ++frames_;
  travel_ = propagateTravel(travel_, T_last_body, alignment, is_jump, scaled(config_.alignment, odometry), leaf_size);
  if (!map.keyframes().needsOne(T_map_body)) {
    return {};
  }
  const bool is_held =
      alignment.leaf_pairs > 0 && !is_jump && travel_.sigma < kHeldShare * config_.correction.drift_reach;
  if (const KeyframeId again = is_held ? map.keyframeAt(T_map_body) : -1; again >= 0) {
    // Where the map leaves directions to odometry, what that may be off goes on adding up.
    travel_ = alignment.degenerate_directions.empty() ? Travel{} : travel_;
    return {std::nullopt, again};
  }
  const Travel travel = std::exchange(travel_, {});
  return {NewKeyframe{{local.utime_us, T_map_body},
                      betweenConstraints(T_map_body, map, local, alignment, travel, leaf_size)},
          -1};
}

MapDelta Corrector::beginFragment(Map& map, Micros utime_us, const Pose& T_map_body) {
  if (!canJoinFragments()) {
    return {};
  }
  MapUpdate update;
  update.keyframe = {{utime_us, T_map_body}, {looseConstraint(map, T_map_body)}};
  travel_ = {};
  frames_ = 0;
  pose_window_ = {};
  geometry_window_ = {};
  return map.apply(std::move(update));
}

Correction Corrector::correct(Map& map, MapDelta updated, const KeyframeDecision& keyframe, const LocalGraph& local,
                              const Alignment& alignment) {
  notePending(updated);
  Correction correction{std::move(updated), alignment.pose};
  mergePending(map, correction);
  if (!keyframe.added && keyframe.taken_up < 0) {
    return correction;
  }
  if (config_.correction.window && keyframe.added) {
    refinePoses(map, local, alignment, correction);
  }
  if (config_.correction.em && keyframe.added) {
    refineLeaves(map, local, alignment, correction);
  }
  if (config_.correction.loop_closure) {
    closeLoop(map, correction);
  }
  const Vec3 here = correction.pose.T_map_body.translation();
  correction.delta = joined(std::move(correction.delta), makeRoom(map, here, kMostLeaving));
  frames_ = 0;
  return correction;
}

Correction Corrector::finish(Map& map, const PoseBelief& pose) {
  Correction correction{{}, pose};
  if (!pages_.read) {
    notePending(bringBack(map, pages_, Vec3::Zero(), std::numeric_limits<double>::infinity()));
  }
  if (const auto loop = loops_.finish(map)) {
    apply(map, *loop, correction);
  }
  mergeAll(map, correction);
  for (const KeyframeId id : map.pagedOutStale()) {
    const Vec3 there = map.keyframes().poses()[static_cast<std::size_t>(id)].T_map_body.translation();
    bringBackInto(correction, map, there, 0);
    mergeAll(map, correction);
    makeRoom(map, correction.pose.T_map_body.translation(), std::numeric_limits<std::size_t>::max());
  }
  correction.delta = joined(std::move(correction.delta), map.apply(mergeSecondNodes(map, classes_, config_)));
  return correction;
}

void Corrector::mergeAll(Map& map, Correction& correction) {
  while (!pending_merges_.empty()) {
    mergePending(map, correction);
  }
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

void Corrector::closeLoop(Map& map, Correction& correction) {
  if (const auto loop = loops_.step(map)) {
    apply(map, *loop, correction);
  }
  for (const LoopKeyframe& keyframe : pages_.read ? std::vector<LoopKeyframe>() : loops_.picked()) {
    const Pose& T_map_keyframe = map.keyframes().poses()[static_cast<std::size_t>(keyframe.id)].T_map_body;
    bringBackInto(correction, map, T_map_keyframe.translation(), loops_.placeRadius());
  }
  loops_.startVerification(map, pages_.read);
}

void Corrector::bringBackInto(Correction& correction, Map& map, const Vec3& centre, double radius) {
  const MapDelta delta = bringBack(map, pages_, centre, radius);
  notePending(delta);
  correction.delta = joined(std::move(correction.delta), delta);
}

void Corrector::apply(Map& map, const MapCorrection& moves, Correction& correction) {
  const Pose T_map_keyframe = map.keyframes().currentPose().T_map_body;
  const MapDelta delta = map.apply(moves);
  correction.delta = joined(std::move(correction.delta), delta);
  notePending(delta);
  mergePending(map, correction);
  const Pose move = orthonormalized(map.keyframes().currentPose().T_map_body * T_map_keyframe.inverse());
  correction.pose = moved(move, correction.pose);
}

void Corrector::notePending(const MapDelta& delta) {
  std::vector<NodeId> found, all;
  std::ranges::set_union(delta.reactivated, delta.colliding, std::back_inserter(found));
  std::ranges::set_union(pending_merges_, found, std::back_inserter(all));
  pending_merges_ = std::move(all);
}

void Corrector::mergePending(Map& map, Correction& correction) {
  std::vector<NodeId> waiting = std::move(pending_merges_);
  pending_merges_.clear();
  if (waiting.empty()) {
    return;
  }
  const auto rest = waiting.begin() + static_cast<std::ptrdiff_t>(std::min(waiting.size(), kMostMerged));
  pending_merges_.assign(rest, waiting.end());
  waiting.erase(rest, waiting.end());
  if (!map.isWhole()) {
    for (const NodeId id : waiting) {
      const MapNode* node = map.find(id);  // what it lies on may be away
      if (node != nullptr) {
        bringBackInto(correction, map, Vec3(node->belief.mean), mergeDistance());
      }
    }
  }
  MapUpdate merged = mergeDuplicates(map, waiting, classes_, config_);
  correction.delta = joined(std::move(correction.delta), map.apply(std::move(merged)));
}

}  // namespace hgg
