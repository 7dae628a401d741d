#pragma once

#include <cstdint>
#include <deque>

#include "core/se3.h"

namespace hgg {

/// What is wrong with odometry, as far as the map can tell.
enum class OdometryFault : std::uint8_t {
  kNone,
  kJump,    // one step that no robot makes, or that the map has refuted
  kFrozen,  // it reports no motion while the robot moves
  kSlip,    // it reports a wrong length of way in the right direction
  kAxes,    // it moves or turns in another direction: orientation in another order, or a sensor mounted otherwise
};

/// Its name for programs: "odometry_jump", "odometry_frozen", "odometry_slip", "odometry_axes"; empty for none.
const char* codeOf(OdometryFault fault);
/// One sentence for people: what it looks like and what to check.
const char* describe(OdometryFault fault);

/// Holds the motion that odometry reports against the motion that the map shows, over the last few frames.
class OdometryMonitor {
 public:
  /// The motion over one step by odometry and as aligned, body frame.
  void learn(const Pose& T_by_odometry, const Pose& T_aligned);
  /// A step that cannot be true.
  void noteJump();
  OdometryFault fault() const;

 private:
  struct Step {
    Pose by_odometry, aligned;
  };

  std::deque<Step> steps_;       // the newest last
  std::deque<int> since_jumps_;  // steps since each jump of late, the oldest first
};

}  // namespace hgg
