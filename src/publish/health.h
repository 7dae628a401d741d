#pragma once

#include <string>
#include <vector>

#include "config.h"
#include "mapper.h"
#include "publish/messages.h"
#include "stats.h"

namespace hgg {

/// The newest frame, as far as its health goes.
struct LatestFrame {
  Micros utime_us = 0;
  FrameTiming timing;
  std::string alignment;  // how its pose came about; empty before the first frame
  int degenerate = 0;     // directions in which it is odometry's
  Tracking tracking = Tracking::kHeld;
  OdometryFault odometry_fault = OdometryFault::kNone;
  KeyframeId fragment = 0;
  Mat6 pose_cov = Mat6::Zero();
  std::string paging_trouble = {};  // StepReport
};

/// What is wrong with where the robot believes to be, and with what it goes by. `odometry` is its channel.
std::vector<Alarm> alarmsOf(const LatestFrame& latest, double odometry_delay_s, const std::string& odometry);

/// The counts at a time of the publisher's clock. What happened in a second is the difference of two.
struct CountsAt {
  Micros time_us = 0;
  RunCounts counts;
};

/// Status at the time of `now`; the frame rate is that since `before`, which must be earlier.
Status describeHealth(const LatestFrame& latest, const CountsAt& before, const CountsAt& now, const Map& map,
                      const std::string& odometry_channel);

/// Fills the fields of `status` that describe the map.
void describeMap(const Map& map, Status& status);

/// Why there was no frame between `before` and `now`: which of the channels in `lcm` is silent.
std::string explainIdleness(const RunCounts& before, const RunCounts& now, const LcmConfig& lcm);

/// What went wrong with messages between `before` and `now`, a line each.
std::vector<std::string> describeTroubles(const RunCounts& before, const RunCounts& now);

}  // namespace hgg
