#pragma once

#include <vector>

#include "map/keyframes.h"

namespace hgg {

/// How far keyframes may have drifted: covariances (m^2, rad^2) of their poses in the tangent of core/se3.h, map axes.
///
/// They are gathered along one path of constraints and not by fusing all of them: those of neighbouring keyframes come
/// from the same leaves and share their errors, so that fusing them as independent ones would promise too much. A path
/// leaves evidence out and promises too little at most.

/// Of every keyframe's pose relative to that of keyframe `from`, each along the path on which its position is known
/// best. Only keyframes up to `newest` are there; negative: all. One that no constraint connects gets kNotConnected.
std::vector<Mat6> covariancesFrom(const KeyframeGraph& graph, KeyframeId from, KeyframeId newest = -1);

/// The same of one keyframe alone; looks no farther than it has to.
Mat6 covarianceBetween(const KeyframeGraph& graph, KeyframeId from, KeyframeId to);

/// Standard deviations of keyframes that nothing connects: they could be anywhere. m, rad.
inline constexpr double kNotConnected = 1e3, kNotConnectedTurn = 3.14;

/// Covariances of all keyframes' poses in the map, whose frame is that of the first keyframe.
///
/// A new keyframe tells where it is, and nothing of older ones: these stay where they are until a loop is closed. So a
/// constraint that is no loop only leads from older keyframes to newer ones, but for those older than a closed loop:
/// with it, the pose graph has weighed all of them.
class PoseCovariances {
 public:
  /// Takes in the newest keyframe, with its constraints. Its cost does not grow with the map.
  void add(const KeyframeGraph& graph);
  /// All anew, after a loop or for a stored map.
  void recompute(const KeyframeGraph& graph);
  /// Zero for none (-1): what is anchored to nothing does not drift.
  Mat6 of(KeyframeId id) const;

 private:
  std::vector<Mat6> covariances_;
};

}  // namespace hgg
