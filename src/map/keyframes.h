#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "map/node.h"

namespace hgg {

struct TimedPose {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
};

/// What is known of how two keyframes lie to each other: by alignment from one to the next, by the part of the map that
/// one was aligned with while it is anchored to the other, or by a closed loop.
struct BetweenConstraint {
  KeyframeId a = 0, b = 0;
  Pose T_a_b = Pose::Identity();
  double sigma = 0;       // m, standard deviation per axis
  double sigma_turn = 0;  // rad
  bool is_loop = false;   // found again without the help of odometry: may be wrong
};

/// How far apart the beliefs about two places may have drifted, one standard deviation.
struct Drift {
  double position = 0;  // m
  double turn = 0;      // rad
};

/// Keyframes and what moves them (T_map_map), ascending.
using KeyframeMoves = std::vector<std::pair<KeyframeId, Pose>>;

/// The poses a robot went through, one every 2 m or 20 degrees, and what ties them together. Nodes of the map hang on
/// them: what moves a keyframe moves its nodes.
class KeyframeGraph {
 public:
  const std::vector<TimedPose>& poses() const { return poses_; }
  const std::vector<BetweenConstraint>& edges() const { return edges_; }
  /// Edges of one keyframe, oldest first.
  std::vector<BetweenConstraint> edgesOf(KeyframeId id) const;
  KeyframeId last() const { return static_cast<KeyframeId>(poses_.size()) - 1; }

  /// The newest of those at a place, or where it was passed nearest; -1 when there are none.
  KeyframeId newestAt(const Vec3& p_map) const;
  /// True when `T_map_body` is far enough from the last keyframe (or the first one) to be one.
  bool needsOne(const Pose& T_map_body) const;
  KeyframeId add(const TimedPose& pose);
  void connect(const BetweenConstraint& edge);
  /// Makes ties among the keyframes that were moved say how they lie now. Closed loops stay as they were found.
  void remeasure(const KeyframeMoves& moves);
  void move(KeyframeId id, const Pose& T_map_body) { poses_.at(static_cast<std::size_t>(id)).T_map_body = T_map_body; }

  /// Drift from `from` to every keyframe, along the edges that let least of it come together: deviations of the edges,
  /// and what the turn so far makes of an edge's length. A negative position marks those with `reach` (m) or more.
  std::vector<Drift> driftFrom(KeyframeId from, double reach) const;

 private:
  std::vector<TimedPose> poses_;
  std::vector<BetweenConstraint> edges_;
  std::vector<std::vector<std::uint32_t>> edges_of_;  // of each keyframe: indices into edges_
};

}  // namespace hgg
