#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// What goes wrong with odometry at one time, on top of its drift. All but a restart change the motion that is
/// reported, so that the error stays for the rest of the drive.
enum class FaultKind {
  kJump,     // one step of `size` m (4 to 8) to any side
  kYawJump,  // one turn of `size` deg (30 to 120) to either side
  kSlip,     // for kFaultSeconds, `size` times the way (0.4 or 1.6); the heading is right
  kFrozen,   // for `size` s (kFaultSeconds) no motion at all
  kRestart,  // at zero again
};
constexpr double kFaultSeconds = 5.0;

struct TimedFault {
  FaultKind kind = FaultKind::kJump;
  double time = 0;             // s from the start of the log
  std::optional<double> size;  // unit by the kind; default: by the seed
};

/// How odometry lies. Everything at its default: it does not.
struct OdometryFaults {
  double delay = 0;          // s: the sample stamped t is the pose of t - delay; negative: of later
  int bursts = 0;            // of the sharpest turns: five to eight frames in which odometry is off, see withFaults()
  bool bursts_stay = false;  // the error of a burst stays; default: its second half takes it back
  bool quaternion_xyzw = false;  // every quaternion in the order x, y, z, w where readers expect w, x, y, z
  std::vector<TimedFault> timed = {};
};

/// KIND[:SIZE]@SECONDS, KIND one of jump, yaw-jump, slip, frozen, restart. Errors say what it may be.
Result<TimedFault> parseFault(const std::string& text);

/// Odometry as it is handed out: `T_odom_body` (a pose every 1/rate_hz s from 0 on) at the frames `kept`, with the
/// faults. In a burst the poses leave their track by 6 degrees to one side and 0.3 to 1 m, and come back to it: 1 to 4
/// degrees a frame. That is what odometry with a lag does in a turn; an error that stayed would turn the rest of the
/// drive, by far more than the drives this is modelled on are off in the end.
std::vector<Pose> withFaults(const std::vector<Pose>& T_odom_body, double rate_hz, const std::vector<std::size_t>& kept,
                             const OdometryFaults& faults, std::uint64_t seed);

}  // namespace hgg
