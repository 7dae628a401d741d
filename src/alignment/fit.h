#pragma once

#include <span>
#include <vector>

#include "alignment/correspondence.h"
#include "alignment/registration.h"

namespace hgg {

/// A covariance has six entries: what fewer points (evidence) are spread like is chance. Such leaves are stray returns
/// and points under a wrong label, and look like small balls that hold the pose in every direction.
inline bool hasExtent(const Belief& leaf) { return leaf.kappa >= 6; }

/// How well a frame lies on the map, counted over its upright leaves that have an extent: walls, trunks, cars. Level
/// ground is left out, because it lies on level ground wherever the frame is put.
struct Fit {
  double known = 0;    // upright leaves of objects that the map knows
  double fitting = 0;  // those of them that lie on a leaf of the map, within three standard deviations

  /// 0 .. 1; 0 when nothing is known.
  double share() const { return known > 0 ? fitting / known : 0; }
};

/// The fit at `T_map_body` of a frame whose objects and leaves are paired with the map's; `gaussians` are those of the
/// leaf pairs. `stride`: only every so many leaves of the frame were looked for in the map (leafStride).
Fit fitOf(const LocalGraph& local, const std::vector<ObjectPair>& pairs, const std::vector<LeafPair>& leaf_pairs,
          std::span<const GaussianPair> gaussians, std::size_t stride, const Pose& T_map_body);

/// The share that is usual where the robot is: a mean over the last ten or so frames that were laid on the map. Not the
/// share itself, but a fall below what is usual says that a frame is in the wrong place, because sensors, labels and
/// trees differ.
class UsualFit {
 public:
  void learn(const Fit& fit);
  /// Whether there is enough of the map in view to tell.
  static bool canTell(const Fit& fit);
  /// Less than half of what is usual fits. False where one cannot tell.
  bool hasCollapsed(const Fit& fit) const;
  double share() const { return share_; }

 private:
  double share_ = 0;  // 0 until the first frame
};

/// Whether a leaf with this covariance (m^2) in a frame whose z points up is anything but a piece of level ground.
bool isUpright(const Mat3& cov);

}  // namespace hgg
