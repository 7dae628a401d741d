#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/types.h"

namespace hgg {

/// A cloud as it came off the wire, labelled or not: nothing filtered yet.
struct SemanticCloud {
  Micros utime_us = 0;
  std::vector<Point> points;          // body frame
  Vec3 p_body_sensor = Vec3::Zero();  // where it was measured from
  std::vector<float> times = {};      // of each point, s after utime_us; empty: all at it
};

struct OdometrySample {
  Micros utime_us = 0;
  Pose T_odom_body = Pose::Identity();
};

/// The unit of measurement: a cloud with the odometry pose at its time.
struct Frame {
  Micros utime_us = 0;
  Pose T_odom_body = Pose::Identity();
  std::vector<Point> points;        // body frame
  bool odometry_restarted = false;  // the odometry began anew since the frame before: its clock went back, or it paused
  Vec3 p_body_sensor = Vec3::Zero();  // range limits are about this point
  std::optional<Pose> T_odom_before =
      std::nullopt;               // odometry's pose at the frame before, where it is no longer what it was then
  std::vector<float> times = {};  // of each point, s after utime_us, until it is deskewed; empty: all at it
};

/// Clouds that did not become frames, by reason.
struct FrameDrops {
  std::int64_t busy = 0;                       // replaced by a newer one before the mapper was free
  std::int64_t odometry = 0;                   // no odometry of their time
  std::int64_t invalid = 0;                    // undecodable, late, duplicate or with a stamp out of line
  std::map<std::string, std::int64_t> causes;  // of `odometry` and `invalid` in detail: "cloud: late or twice"

  std::int64_t total() const { return busy + odometry + invalid; }
};

}  // namespace hgg
