#pragma once

#include <optional>

#include "alignment/registration.h"
#include "config.h"

namespace hgg {

/// The pose after an odometry motion T_last_body, from the last refined pose: its uncertainty is carried along and
/// grows with the way and the turn (config.odometry_*), next to nothing at rest. nullopt where the motion is none a
/// robot makes between two frames (more than 30 m or 120 degrees): odometry has jumped.
std::optional<PoseBelief> propagatePose(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config);

/// The pose a new map starts from, known exactly as the map's frame is a gauge; or (`gauge` false) that of a robot
/// that goes on in a map it has, or whose odometry jumped: good to 0.3 m and 3 degrees.
PoseBelief startPose(const Pose& T_map_body, bool gauge);

}  // namespace hgg
