#pragma once

#include <optional>

#include "alignment/registration.h"
#include "config.h"

namespace hgg {

/// The pose after an odometry motion T_last_body from the last refined pose. Its uncertainty is carried along and grows
/// with the distance and the turn (config.odometry_*), next to nothing at rest. nullopt where odometry has jumped: no
/// robot moves by more than 30 m or 120 degrees between two frames.
std::optional<PoseBelief> propagatePose(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config);

/// The pose that a drive starts from. In a new map (`gauge` true) it is known exactly, because it defines the map's
/// frame. In a stored map, or after a jump of odometry, it is known to 0.3 m and 3 degrees.
PoseBelief startPose(const Pose& T_map_body, bool gauge);

}  // namespace hgg
