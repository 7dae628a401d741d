#include "alignment/tracker.h"

#include <algorithm>
#include <limits>

#include "alignment/propagation.h"
#include "core/so3.h"
#include "core/units.h"

namespace hgg {
namespace {

/// A robot is lost when this many frames in a row did not fit.
constexpr int kMostDoubts = 5;
/// A frame that a search has laid on the map must fit this share of what is usual.
constexpr double kRecoveredShare = 0.75;
/// The first search looks this far, in leaf sizes and rad: 4.8 m outdoors, 1.2 m indoors; each further one by half as
/// much more.
constexpr double kReachLeaves = 12, kReachTurn = 20 * kDegree;
constexpr double kWider = 0.5;
/// Longer than this no velocity is constant, s.
constexpr double kLongestCoast = 1;
/// At constant velocity the pose is this many times as uncertain as its last errors were large.
constexpr double kCoastMargin = 2;
/// m/s^2: no wheel or foot speeds a robot up by more. m/s: the speed it is taken to have while none is known. m: what
/// odometry may correct at once.
constexpr double kGravity = 9.81, kUsualSpeed = 30, kSlack = 0.5;
/// Steps before what the robot did is held against what odometry says: the first ones of a drive are often wrong, as
/// odometry and map settle.
constexpr int kWarmUp = 5;
constexpr double kZeroTurn = 5 * kDegree;                                                 // rad
constexpr double kDisputedShare = 0.5, kDisputedWay = 0.05, kDisputedTurn = 2 * kDegree;  // -, m, rad
/// Odometry has jumped when the map refutes a step by more than kSlack and this share of the way, or by this turn, rad.
constexpr double kJumpShare = 1, kJumpTurn = 10 * kDegree;

Pose power(const Pose& T, double exponent) {
  Pose out = Pose::Identity();
  out.linear() = expRotation(exponent * logRotation(T.linear()));
  out.translation() = exponent * T.translation();
  return out;
}

MotionNoise times(const MotionNoise& noise, const NoiseScale& scale) {
  return {noise.position * scale.position, noise.turn * scale.turn};
}

/// At constant velocity: `errors` are the last ones, in standard deviations of the config's odometry.
MotionNoise velocityNoise(const Pose& motion, const NoiseScale& errors, const AlignmentConfig& config) {
  MotionNoise noise = odometryNoise(motion, config);
  noise.position = std::max(noise.position, config.odometry_jitter);
  noise.turn = std::max(noise.turn, kDegree * config.odometry_jitter_deg);
  return times(noise, {std::max(1.0, kCoastMargin * errors.position), std::max(1.0, kCoastMargin * errors.turn)});
}

/// Whether two predictions of a motion are so different that one of them must be wrong: by half of the larger one, and
/// by more than a robot at work changes its motion between two frames anyway.
bool areDisputed(const Pose& a, const Pose& b) {
  const double way = std::max(a.translation().norm(), b.translation().norm());
  const double turn = std::max(turnOf(a), turnOf(b));
  return (a.translation() - b.translation()).norm() > std::max(kDisputedShare * way, kDisputedWay) ||
         turnOf(a.inverse() * b) > std::max(kDisputedShare * turn, kDisputedTurn);
}

}  // namespace

const char* nameOf(Tracking tracking) {
  switch (tracking) {
    case Tracking::kHeld:
      return "tracking";
    case Tracking::kRecovered:
      return "recovered";
    case Tracking::kDoubtful:
      return "doubtful";
    case Tracking::kLost:
      return "lost";
  }
  return "";
}

Pose Tracker::coasting(Micros from_us, Micros to_us) const {
  const double span = 1e-6 * static_cast<double>(to_us - from_us);
  const bool is_usable = step_us_ > 0 && span > 0 && span < kLongestCoast;
  return is_usable ? power(T_step_, static_cast<double>(to_us - from_us) / static_cast<double>(step_us_))
                   : Pose::Identity();
}

/// Whatever a robot does, gravity bounds how fast it speeds up, and no robot turns by more than 120 degrees between two
/// frames.
bool Tracker::isPlausible(const Pose& T_last_body, Micros utime_us) const {
  const double span = 1e-6 * static_cast<double>(utime_us - last_->utime_us);
  const double step_span = 1e-6 * static_cast<double>(step_us_);
  const double speed = step_us_ > 0 ? T_step_.translation().norm() / step_span : kUsualSpeed;
  const double farthest =
      span > 0 ? kSlack + (speed + kGravity * span) * span : std::numeric_limits<double>::infinity();
  return isPossibleMotion(T_last_body) && T_last_body.translation().norm() <= farthest;
}

/// Odometry that jumps to where it once began has begun anew, unless it only comes back from a jump.
bool Tracker::hasRestarted(const Frame& frame) const {
  // Odometry's frame in the map as it was before the jump, which may be one that is still in doubt.
  const std::optional<Pose> T_map_odom = doubts_ > 0 && good_ ? odometryFrameOf(*good_) : T_map_odom_before_;
  if (T_map_odom && !areDistinctPoses(*T_map_odom * frame.T_odom_body, last_->pose.T_map_body)) {
    return false;
  }
  const auto isZero = [](const Pose& T) { return T.translation().norm() < kSlack && turnOf(T) < kZeroTurn; };
  const Pose step = last_->T_odom_body.inverse() * frame.T_odom_body;
  return isZero(frame.T_odom_body) && !isZero(last_->T_odom_body) && !isPlausible(step, frame.utime_us);
}

/// Another delay was applied to odometry: what it said of the frames before is no longer what it said then.
void Tracker::rebase(const Frame& frame) {
  if (!frame.T_odom_before) {
    return;
  }
  const Pose T_now_then = *frame.T_odom_before * last_->T_odom_body.inverse();
  last_->T_odom_body = *frame.T_odom_before;
  if (good_) {
    good_->T_odom_body = orthonormalized(T_now_then * good_->T_odom_body);
  }
}

Prediction Tracker::predict(const Frame& frame, const AlignmentConfig& config) {
  Prediction prediction;
  if (!last_) {
    prediction.is_start = true;
    return prediction;
  }
  rebase(frame);
  if (is_lost_ || frame.odometry_restarted || hasRestarted(frame)) {
    prediction.is_unknown = true;
    prediction.pose = last_->pose;
    return prediction;
  }
  const Pose by_odometry = last_->T_odom_body.inverse() * frame.T_odom_body;
  const Pose by_velocity = coasting(last_->utime_us, frame.utime_us);
  const bool is_possible = isPossibleMotion(by_odometry);
  const bool is_believed = is_possible && trust_.isBelieved();
  const bool has_warmed_up = steps_ >= kWarmUp;
  prediction.has_to_fit = !is_possible || (has_warmed_up && !isPlausible(by_odometry, frame.utime_us));
  const Pose& motion = is_believed ? by_odometry : by_velocity;
  const MotionNoise noise = is_believed ? times(odometryNoise(motion, config), trust_.noiseOf(motion))
                                        : velocityNoise(motion, trust_.velocityErrors(), config);
  prediction.pose = propagatePose(last_->pose, motion, noise).value_or(last_->pose);
  prediction.guesses = {prediction.pose.T_map_body};
  prediction.is_disputed = good_ && is_possible && has_warmed_up && areDisputed(by_odometry, by_velocity);
  prediction.is_unproven = good_ && !has_warmed_up && !is_proven_ && areDisputed(by_odometry, Pose::Identity());
  if (good_ && is_believed) {
    prediction.guesses.push_back(good_->pose.T_map_body * coasting(good_->utime_us, frame.utime_us));
  } else if (good_ && is_possible) {
    prediction.guesses.push_back(odometryFrameOf(*good_) * frame.T_odom_body);
  }
  return prediction;
}

Tracking Tracker::judge(const Prediction& prediction, const Alignment& alignment) const {
  return prediction.has_to_fit || usual_.hasCollapsed(alignment.fit) ? Tracking::kDoubtful : Tracking::kHeld;
}

SearchReach Tracker::reach(double leaf_size) const {
  return {(1 + kWider * doubts_) * kReachLeaves * leaf_size, kReachTurn};
}

double Tracker::leastShare() const { return kRecoveredShare * usual_.share(); }

void Tracker::accept(const Frame& frame, const Alignment& alignment, const PoseBelief& pose,
                     const AlignmentConfig& config) {
  if (good_) {
    const Pose by_odometry = good_->T_odom_body.inverse() * frame.T_odom_body;
    const Pose by_velocity = coasting(good_->utime_us, frame.utime_us);
    const Pose aligned = *motionTo(pose.T_map_body);
    const Pose off = by_odometry.inverse() * aligned;
    if (off.translation().norm() > kSlack + kJumpShare * aligned.translation().norm() || turnOf(off) > kJumpTurn) {
      monitor_.noteJump();
      T_map_odom_before_ = odometryFrameOf(*good_);
    }
    if (alignment.source == PoseSource::kAligned) {
      monitor_.learn(by_odometry, aligned);
      trust_.learn(by_odometry, step_us_ > 0 ? by_velocity : by_odometry, aligned, config);
    }
    ++steps_;
    T_step_ = aligned;
    step_us_ = frame.utime_us - good_->utime_us;
  }
  usual_.learn(alignment.fit);
  last_ = good_ = {pose, frame.T_odom_body, frame.utime_us};
  doubts_ = 0;
}

Tracking Tracker::hold(const Frame& frame, const Prediction& prediction) {
  last_ = {prediction.pose, frame.T_odom_body, frame.utime_us};
  ++doubts_;
  is_lost_ = doubts_ >= kMostDoubts;
  return is_lost_ ? Tracking::kLost : Tracking::kDoubtful;
}

void Tracker::startAt(const Frame& frame, const PoseBelief& pose) {
  last_ = {pose, frame.T_odom_body, frame.utime_us};
  good_.reset();
  T_step_ = Pose::Identity();
  step_us_ = 0;
  steps_ = 0;
  doubts_ = 0;
  is_lost_ = false;
  is_proven_ = false;
}

void Tracker::moveTo(const PoseBelief& pose) {
  last_->pose = pose;
  if (doubts_ == 0) {
    good_->pose = pose;
  }
}

std::optional<Pose> Tracker::motionTo(const Pose& T_map_body) const {
  return good_ ? std::optional<Pose>(good_->pose.T_map_body.inverse() * T_map_body) : std::nullopt;
}

}  // namespace hgg
