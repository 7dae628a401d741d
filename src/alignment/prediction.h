#pragma once

#include "alignment/registration.h"
#include "config.h"

namespace hgg {

/// The pose after an odometry motion T_last_body, from the last refined pose: its uncertainty is carried along and
/// grows with the way and the turn (config.odometry_*).
PoseBelief predictPose(const PoseBelief& last, const Pose& T_last_body, const AlignmentConfig& config);

/// The pose an unmoved map starts from: known exactly, as the map's frame is a gauge.
PoseBelief startPose(const Pose& T_map_body);

}  // namespace hgg
