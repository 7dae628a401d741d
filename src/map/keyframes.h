#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "map/between_constraint.h"
#include "map/node.h"

namespace hgg {

struct TimedPose {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
};

/// By how much the relative pose of two keyframes may be wrong, one standard deviation.
struct Drift {
  double position = 0;  // m
  double turn = 0;      // rad
};

/// The constraints between the keyframes `from` and `to`, loops aside, turn out to be looser by a factor than was
/// believed.
struct Loosening {
  KeyframeId from = 0, to = 0;
  double factor = 1;  // on the standard deviations
};

/// Keyframes and the rigid motions that move them (T_map_map), ascending by keyframe.
using KeyframeMoves = std::vector<std::pair<KeyframeId, Pose>>;

/// Poses of the robot, one every 2 m or 20 degrees, and the between constraints that hold them together. Each node of
/// the map is anchored to a keyframe and moves rigidly with it.
class KeyframeGraph {
 public:
  const std::vector<TimedPose>& poses() const { return poses_; }
  const std::vector<BetweenConstraint>& edges() const { return edges_; }
  /// Constraints of one keyframe, oldest first.
  std::vector<BetweenConstraint> edgesOf(KeyframeId id) const;
  /// Calls visit(const BetweenConstraint&) for each of them, without a copy.
  template <typename Visit>
  void forEachEdgeOf(KeyframeId id, Visit visit) const {
    for (const std::uint32_t index : edges_of_.at(static_cast<std::size_t>(id))) {
      visit(edges_[index]);
    }
  }
  KeyframeId last() const { return static_cast<KeyframeId>(poses_.size()) - 1; }
  /// The one that the robot is at, with which its pose moves: the last one, or an older one that it has met again.
  KeyframeId current() const { return current_; }
  const TimedPose& currentPose() const { return poses_.at(static_cast<std::size_t>(current_)); }
  void takeUp(KeyframeId id) { current_ = id; }

  /// The newest of the keyframes at a place, which are those within 2 m of the distance of the nearest one; -1 when
  /// there are none.
  KeyframeId newestAt(const Vec3& p_map) const;
  /// True when `T_map_body` is far enough from the current keyframe to become one, or when there are none yet.
  bool needsOne(const Pose& T_map_body) const;
  /// Whether a pose is so near to a keyframe's that it need not become one itself.
  bool isAt(KeyframeId id, const Pose& T_map_body) const;
  KeyframeId add(const TimedPose& pose);
  void connect(const BetweenConstraint& edge);
  /// Sets the constraints among the moved keyframes to their relative poses of now. Closed loops stay as they were
  /// found.
  void remeasure(const KeyframeMoves& moves);
  void loosen(const Loosening& loosening);
  void move(KeyframeId id, const Pose& T_map_body) { poses_.at(static_cast<std::size_t>(id)).T_map_body = T_map_body; }

  /// The fragment of each keyframe, named by its oldest one: keyframes are of one fragment when constraints that are
  /// not loose lead from one to the other.
  std::vector<KeyframeId> fragments() const;

  /// Drift from keyframe `from` to every keyframe, along the path of constraints with the least drift. Along a path the
  /// deviations of the constraints add up as independent ones, and the turn so far swings every further constraint by
  /// its length. A negative position marks keyframes with a drift of `reach` (m) or more.
  std::vector<Drift> driftFrom(KeyframeId from, double reach) const;
  /// The same to one keyframe alone; looks no farther than it has to.
  Drift driftFromTo(KeyframeId from, KeyframeId to) const;

 private:
  std::vector<TimedPose> poses_;
  std::vector<BetweenConstraint> edges_;
  KeyframeId current_ = -1;
  std::vector<std::vector<std::uint32_t>> edges_of_;  // of each keyframe: indices into edges_
};

}  // namespace hgg
