#pragma once

#include <optional>
#include <span>
#include <vector>

#include "frame/frame.h"
#include "frame/odometry_buffer.h"

namespace hgg {

/// Takes a cloud from the frame of its sensor to that of the body.
void moveToBody(SemanticCloud& cloud, const Pose& T_body_sensor);

/// How the body moved between two times of the clouds' clock, T_to_from: takes what was seen from the body at `from_us`
/// to the body at `to_us`. nullopt where odometry does not tell, or began anew in between. By up to kMotionReach_us
/// beyond its samples the body is taken to move on as it did. `delay_us`: of odometry's stamps (OdometryDelay).
constexpr Micros kMotionReach_us = 300'000;
std::optional<Pose> motionBetween(const OdometryBuffer& odometry, Micros from_us, Micros to_us, Micros delay_us);

/// Takes each point, seen from the body at `utime_us` + its own time, to the body at `to_us`. Without times all are of
/// `utime_us`. False, and nothing moved, where odometry does not tell.
bool movePoints(std::span<Point> points, std::span<const float> times, Micros utime_us, Micros to_us,
                const OdometryBuffer& odometry, Micros delay_us);

/// Takes the points of a frame to the body at its time, and forgets theirs. False where odometry does not tell.
bool deskew(Frame& frame, const OdometryBuffer& odometry, Micros delay_us);

}  // namespace hgg
