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

/// How far apart the beliefs about two places may have drifted, one standard deviation.
struct Drift {
  double position = 0;  // m
  double turn = 0;      // rad
};

/// Keyframes and the transforms (T_map_map) that move them, ascending.
using KeyframeMoves = std::vector<std::pair<KeyframeId, Pose>>;

/// The poses a robot went through, one every 2 m or 20 degrees, and the constraints between them. Every node of the map
/// is anchored to a keyframe and moves rigidly with it.
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
  /// Sets the constraints among the keyframes that were moved to how these lie now. Loops stay as they were found.
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
