#pragma once

#include <vector>

#include "alignment/align.h"
#include "config.h"
#include "map/map.h"

namespace hgg {

/// Uncertainty of the motion from the last keyframe to the present frame, one standard deviation.
struct Travel {
  double sigma = 0;                        // m
  double sigma_turn = 0;                   // rad
  bool jumped = false;                     // somewhere on the way odometry gave no usable motion
  double expected = 0, expected_turn = 0;  // m, rad: what is expected where sigma is cautious (BetweenConstraint)
};

/// Propagates the uncertainty over one more motion, T_last_body. Where the frame was aligned with the map it grows by
/// what alignment loses; in position or rotation that the map does not constrain it grows by odometry's own error.
/// `is_jump`: odometry gave no usable motion; then, and until the next keyframe, it is that of the place in the map,
/// which a frame tells that the map holds in every direction. `leaf_size` (m) is the map's.
Travel propagateTravel(const Travel& travel, const Pose& T_last_body, const Alignment& alignment, bool is_jump,
                       const AlignmentConfig& odometry, double leaf_size);

/// Constraints of a new keyframe at T_map_body: one to the last keyframe, and one to each of the (at most two)
/// keyframes to which most leaves are anchored that the frame was aligned with. After a jump, or at the start in a
/// stored map, the motion from the last keyframe is unknown and only the place in the map is known: then the
/// constraints go to those anchors alone or, where there are none, to the nearest keyframe. `leaf_size` (m) is the
/// map's. Empty in an empty map.
std::vector<BetweenConstraint> betweenConstraints(const Pose& T_map_body, const Map& map, const LocalGraph& local,
                                                  const Alignment& alignment, const Travel& travel, double leaf_size);

/// The constraint of a keyframe at T_map_body that may lie anywhere, from the last keyframe (isLoose). Needs a
/// keyframe.
BetweenConstraint looseConstraint(const Map& map, const Pose& T_map_body);

}  // namespace hgg
