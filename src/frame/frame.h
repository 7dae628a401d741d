#pragma once

#include <cstdint>
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

/// Clouds that did not become frames, by reason.
struct FrameDrops {
  std::int64_t busy = 0;      // replaced by a newer one before the mapper was free
  std::int64_t odometry = 0;  // no odometry within the wait
  std::int64_t invalid = 0;   // undecodable, late or duplicate

  std::int64_t total() const { return busy + odometry + invalid; }
};

}  // namespace hgg
