#pragma once

#include <span>

#include "bus/codec.h"
#include "bus/log.h"

namespace hgg {

/// Appends a frame as the mapper expects it: POSE_ODOM, then LIDAR_SEMANTIC of the same time. Returns an error line,
/// empty when done.
inline std::string writeFrame(LogWriter& log, Micros utime_us, const Pose& T_odom_body, std::span<const Point> points) {
  const std::string error = log.write("POSE_ODOM", utime_us, encodePose(utime_us, T_odom_body));
  return error.empty() ? log.write("LIDAR_SEMANTIC", utime_us, encodeSemanticCloud(utime_us, points)) : error;
}

}  // namespace hgg
