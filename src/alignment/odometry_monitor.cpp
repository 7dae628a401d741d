#include "alignment/odometry_monitor.h"

#include <cmath>
#include <cstddef>

#include "core/so3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr std::size_t kWindow = 10, kFewest = 4;  // steps
constexpr int kJumpTold = 100;                    // steps for which a jump is told
constexpr std::size_t kLastingJumps = 3;          // as many within them are no accident: its motion is wrong throughout
/// Motion over the window below which nothing can be said: m, rad. Alignment's own noise is a tenth of it.
constexpr double kMoved = 0.25, kTurned = 5 * kDegree;
constexpr double kStill = 0.02;               // share of the true motion that a frozen odometry may report
constexpr double kShort = 0.8, kLong = 1.25;  // shares of the true way beyond which it slips
constexpr double kSameDirection = 0.8;        // cosine
/// A difference of motion, as a share of it, that is a fault at all.
constexpr double kOff = 0.2;

struct Motion {
  Vec3 way = Vec3::Zero(), turn = Vec3::Zero();  // summed over the steps
  double length = 0, angle = 0;                  // sums of their norms

  void add(const Pose& T) {
    const Vec3 w = logRotation(T.linear());
    way += T.translation(), turn += w;
    length += T.translation().norm(), angle += w.norm();
  }
};

/// Whether two vectors, the second of which is long enough to have a direction, point the same way.
bool pointAlike(const Vec3& a, const Vec3& b) { return a.dot(b) > kSameDirection * a.norm() * b.norm(); }

}  // namespace

const char* codeOf(OdometryFault fault) {
  switch (fault) {
    case OdometryFault::kNone:
      return "";
    case OdometryFault::kJump:
      return "odometry_jump";
    case OdometryFault::kFrozen:
      return "odometry_frozen";
    case OdometryFault::kSlip:
      return "odometry_slip";
    case OdometryFault::kAxes:
      return "odometry_axes";
  }
  return "";
}

const char* describe(OdometryFault fault) {
  switch (fault) {
    case OdometryFault::kNone:
      return "";
    case OdometryFault::kJump:
      return "odometry jumped: the pose goes on by the map";
    case OdometryFault::kFrozen:
      return "odometry stands still while the robot moves: is its source alive?";
    case OdometryFault::kSlip:
      return "odometry reports another length of way than the map shows: wheels slip, or its scale is wrong";
    case OdometryFault::kAxes:
      return "odometry moves in another direction than the map shows: check the order of its quaternion (w x y z) and "
             "how the sensor is mounted (T_body_lidar)";
  }
  return "";
}

void OdometryMonitor::learn(const Pose& T_by_odometry, const Pose& T_aligned) {
  steps_.push_back({T_by_odometry, T_aligned});
  if (steps_.size() > kWindow) {
    steps_.pop_front();
  }
  for (int& steps : since_jumps_) {
    ++steps;
  }
  std::erase_if(since_jumps_, [](int steps) { return steps > kJumpTold; });
}

void OdometryMonitor::noteJump() { since_jumps_.push_back(0); }

OdometryFault OdometryMonitor::fault() const {
  Motion odometry, aligned, odometry_now, aligned_now;  // over the window, over its newest steps
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    odometry.add(steps_[k].by_odometry), aligned.add(steps_[k].aligned);
    if (k + kFewest >= steps_.size()) {
      odometry_now.add(steps_[k].by_odometry), aligned_now.add(steps_[k].aligned);
    }
  }
  const bool moves = aligned.length > kMoved, turns = aligned.angle > kTurned;
  const OdometryFault jump = since_jumps_.empty() ? OdometryFault::kNone : OdometryFault::kJump;
  if (steps_.size() < kFewest || !(moves || turns)) {
    return jump;
  }
  if ((aligned_now.length > kMoved || aligned_now.angle > kTurned) &&
      odometry_now.length < kStill * (aligned_now.length + kMoved) &&
      odometry_now.angle < kStill * (aligned_now.angle + kTurned)) {
    return OdometryFault::kFrozen;
  }
  const bool is_way_off = moves && (odometry.way - aligned.way).norm() > kOff * aligned.length;
  const bool is_turn_off = turns && (odometry.turn - aligned.turn).norm() > 2 * kOff * aligned.angle + kTurned / 2;
  if ((is_way_off && !pointAlike(odometry.way, aligned.way)) ||
      (is_turn_off && !pointAlike(odometry.turn, aligned.turn))) {
    const bool is_accident = !since_jumps_.empty() && since_jumps_.size() < kLastingJumps;
    return is_accident ? OdometryFault::kJump : OdometryFault::kAxes;
  }
  const double share = odometry.way.norm() / std::max(aligned.way.norm(), 1e-6);
  if (is_way_off && (share < kShort || share > kLong)) {
    return OdometryFault::kSlip;
  }
  return jump;
}

}  // namespace hgg
