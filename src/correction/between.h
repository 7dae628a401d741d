#pragma once

#include <vector>

#include "alignment/align.h"
#include "config.h"
#include "map/map.h"

namespace hgg {

/// What may have been lost on the way from the last keyframe to the present frame, one standard deviation.
struct Travel {
  double sigma = 0;       // m
  double sigma_turn = 0;  // rad
  bool jumped = false;    // odometry said nothing usable on the way
};

/// `travel` and one more step of odometry, T_last_body: what alignment loses where the frame was aligned, what odometry
/// does where it was not, wholly or in some direction. `is_jump`: odometry said nothing usable.
Travel travelOn(const Travel& travel, const Pose& T_last_body, const Alignment& alignment, bool is_jump,
                const Config& config);

/// Ties of a keyframe at T_map_body to the last one, and to the keyframes that most of what it was aligned with is
/// anchored to. After a jump, or in a stored map, the way from the last one is not known: only where in the map the
/// robot is. Then what it was aligned with ties it alone, or else the nearest keyframe.
std::vector<BetweenConstraint> betweenConstraints(const Pose& T_map_body, const Map& map, const LocalGraph& local,
                                                  const Alignment& alignment, const Travel& travel,
                                                  const Config& config);

}  // namespace hgg
