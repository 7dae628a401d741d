#pragma once

#include <optional>

#include "alignment/registration.h"
#include "config.h"

namespace hgg {

/// Standard deviation of a predicted motion: m, rad.
struct MotionNoise {
  double position = 0, turn = 0;
};

/// What the config expects of odometry over a motion: it grows with the distance and the turn, next to nothing at rest.
MotionNoise odometryNoise(const Pose& T_last_body, const AlignmentConfig& config);

/// Whether a robot can have moved so between two frames: by no more than 30 m and 120 degrees.
bool isPossibleMotion(const Pose& T_last_body);

/// The pose after a motion T_last_body from the last refined pose, whose uncertainty is carried along and grows by
/// `noise`. nullopt where the motion is impossible.
std::optional<PoseBelief> propagatePose(const PoseBelief& last, const Pose& T_last_body, const MotionNoise& noise);

/// The pose that a drive starts from. In a new map (`gauge` true) it is known exactly, because it defines the map's
/// frame. In a stored map whose place the user gives, it is known
/// to 0.3 m and 3 degrees.
PoseBelief startPose(const Pose& T_map_body, bool gauge);

}  // namespace hgg
