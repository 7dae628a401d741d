#pragma once

#include <optional>
#include <vector>

#include "alignment/align.h"
#include "alignment/fit.h"
#include "alignment/odometry_monitor.h"
#include "alignment/odometry_trust.h"
#include "alignment/recovery.h"
#include "config.h"
#include "frame/frame.h"

namespace hgg {

/// Whether the robot knows where it is in the map: the frame lies on the map as it should; it does after a wider
/// search; it does not, so that nothing of it enters the map; it has not for so long that a new fragment of map begins.
enum class Tracking : std::uint8_t { kHeld, kRecovered, kDoubtful, kLost };

/// Its name in messages: "tracking", "recovered", "doubtful" or "lost".
const char* nameOf(Tracking tracking);

/// Where a frame is looked for.
struct Prediction {
  PoseBelief pose;
  std::vector<Pose> guesses;  // T_map_body: the pose, and what else the robot may have done; where a search starts
  bool is_disputed = false;   // odometry and constant velocity say very different things: the first two guesses
  bool is_start = false;      // there was no frame before it
  bool is_unknown = false;    // nothing says where in the map it is: a new fragment begins
  bool is_unproven = false;   // odometry reports motion, and nothing has shown yet that it can be believed
  bool has_to_fit = false;    // odometry's step is hardly possible: only the map can confirm a pose
};

/// Follows the pose from frame to frame, judges how far odometry and the pose itself can be believed, and says when
/// they cannot.
class Tracker {
 public:
  /// Where the frame is expected: by odometry from the last pose, with the noise that odometry has shown, or at
  /// constant velocity while that predicts better.
  Prediction predict(const Frame& frame, const AlignmentConfig& config);

  /// Judges a frame that was aligned from its prediction.
  Tracking judge(const Prediction& prediction, const Alignment& alignment) const;
  /// How far to look for a frame that does not fit, and what share of the map's leaves in view has to fit there.
  SearchReach reach(double leaf_size) const;
  double leastShare() const;

  /// A search of the map has found the frame where odometry put it: the next ones need none.
  void proveOdometry() { is_proven_ = true; }
  /// The frame fits, at `pose`.
  void accept(const Frame& frame, const Alignment& alignment, const PoseBelief& pose, const AlignmentConfig& config);
  /// It does not: the pose goes on as predicted. Returns kLost when that has lasted too long, else kDoubtful.
  Tracking hold(const Frame& frame, const Prediction& prediction);
  /// A drive or a new fragment of map starts at a pose.
  void startAt(const Frame& frame, const PoseBelief& pose);
  /// A correction has moved the newest pose.
  void moveTo(const PoseBelief& pose);

  bool hasStarted() const { return last_.has_value(); }
  const PoseBelief& pose() const { return last_->pose; }
  /// The motion since the last frame that fitted; nullopt when there is none.
  std::optional<Pose> motionTo(const Pose& T_map_body) const;
  const OdometryTrust& odometry() const { return trust_; }
  OdometryFault odometryFault() const { return monitor_.fault(); }
  double usualShare() const { return usual_.share(); }

 private:
  struct Known {
    PoseBelief pose;
    Pose T_odom_body;
    Micros utime_us = 0;
  };

  /// Where odometry's frame lies in the map, by one frame (T_map_odom).
  static Pose odometryFrameOf(const Known& known) { return known.pose.T_map_body * known.T_odom_body.inverse(); }
  void rebase(const Frame& frame);
  bool isPlausible(const Pose& T_last_body, Micros utime_us) const;
  bool hasRestarted(const Frame& frame) const;
  /// The motion at constant velocity from one time to another.
  Pose coasting(Micros from_us, Micros to_us) const;

  std::optional<Known> last_;              // the newest frame
  std::optional<Known> good_;              // the newest one that fitted
  Pose T_step_ = Pose::Identity();         // between the last two frames that fitted
  Micros step_us_ = 0;                     // its duration; 0: not known
  std::optional<Pose> T_map_odom_before_;  // before odometry's last jump
  OdometryTrust trust_;
  OdometryMonitor monitor_;
  UsualFit usual_;
  int steps_ = 0;   // between frames that fitted, since the start
  int doubts_ = 0;  // frames in a row that did not fit
  bool is_lost_ = false;
  bool is_proven_ = false;
};

}  // namespace hgg
