#pragma once

#include <vector>

#include "core/types.h"

namespace hgg {

/// A labelled cloud as it came off the wire: nothing filtered yet.
struct SemanticCloud {
  Micros utime_us = 0;
  std::vector<Point> points;  // body frame
};

struct OdometrySample {
  Micros utime_us = 0;
  Pose T_odom_body = Pose::Identity();
};

/// The unit of measurement: a cloud with the odometry pose at its time.
struct Frame {
  Micros utime_us = 0;
  Pose T_odom_body = Pose::Identity();
  std::vector<Point> points;  // body frame
};

}  // namespace hgg
