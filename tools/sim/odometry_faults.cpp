#include "sim/odometry_faults.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/units.h"
#include "frame/odometry_buffer.h"
#include "sim/sensor.h"

namespace hgg {
namespace {

struct KindName {
  const char* name;
  FaultKind kind;
};
constexpr std::array kKindNames{KindName{"jump", FaultKind::kJump}, KindName{"yaw-jump", FaultKind::kYawJump},
                                KindName{"slip", FaultKind::kSlip}, KindName{"frozen", FaultKind::kFrozen},
                                KindName{"restart", FaultKind::kRestart}};

constexpr double kBurst_deg = 6.0;                      // in all
constexpr double kBurst_m_min = 0.3, kBurst_m_max = 1;  // in all
constexpr int kBurstFramesMin = 5, kBurstFramesMax = 8;
constexpr double kTurnWindow = 1.0;  // s over which the sharpness of a turn is taken
constexpr double kTurnsApart = 5.0;  // s: nearer ones are the same turn

std::optional<double> numberIn(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

Pose planarStep(double forward, double left, double yaw) {
  Pose step = Pose::Identity();
  step.translation() = Vec3(forward, left, 0.0);
  step.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  return step;
}

/// The pose `index` frames after the first, between frames interpolated, outside of them the nearest.
Pose poseAtFrame(const std::vector<Pose>& poses, double index) {
  constexpr double kSame = 1e-6;  // frames: rounding of a time
  index = std::clamp(index, 0.0, static_cast<double>(poses.size() - 1));
  const auto i = static_cast<std::size_t>(index + kSame);
  const double share = index - static_cast<double>(i);
  return share < kSame ? poses[i] : interpolate(poses[i], poses[i + 1], share);
}

/// Numbers of one fault.
class FaultDice {
 public:
  FaultDice(std::uint64_t seed, std::uint64_t stream, std::size_t fault)
      : key_(keyFor(seed, Purpose::kOdometryFaults, stream, fault)) {}
  double between(double lo, double hi) { return lo + (hi - lo) * uniform(key_, next_++); }
  double sign() { return between(0, 1) < 0.5 ? -1.0 : 1.0; }

 private:
  RandomKey key_;
  std::uint64_t next_ = 0;
};
constexpr std::uint64_t kBurstDice = 0, kTimedDice = 1;

// ---------------------------------------------------------------------------------------------------- bursts

/// The middles of the `count` sharpest turns, sharpest first; fewer where the way is too short.
std::vector<std::size_t> sharpestTurns(const std::vector<Pose>& poses, double rate_hz, int count) {
  const auto half = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kTurnWindow * rate_hz / 2)));
  const std::size_t margin = half + kBurstFramesMax;
  std::vector<std::pair<double, std::size_t>> turns;
  for (std::size_t i = margin; i + margin < poses.size(); ++i) {
    const Mat3 R = poses[i - half].linear().transpose() * poses[i + half].linear();
    turns.emplace_back(-std::abs(std::atan2(R(1, 0), R(0, 0))), i);
  }
  std::ranges::sort(turns);
  std::vector<std::size_t> chosen;
  for (const auto& [sharpness, i] : turns) {
    const bool is_apart = std::ranges::all_of(chosen, [&, at = i](std::size_t other) {
      return std::abs(static_cast<double>(at) - static_cast<double>(other)) > kTurnsApart * rate_hz;
    });
    if (is_apart && static_cast<int>(chosen.size()) < count) {
      chosen.push_back(i);
    }
  }
  return chosen;
}

/// Shares of 1 for `count` frames, none more than twice another.
std::vector<double> unevenShares(int count, FaultDice& dice) {
  std::vector<double> shares;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    shares.push_back(dice.between(0.7, 1.3));
    sum += shares.back();
  }
  std::ranges::transform(shares, shares.begin(), [sum](double share) { return share / sum; });
  return shares;
}

/// How far a burst is off, as a share of its most, at each of its frames.
std::vector<double> burstCourse(bool stays, FaultDice& dice) {
  const int frames = static_cast<int>(dice.between(kBurstFramesMin, kBurstFramesMax + 1));
  const int out = stays ? frames : (frames + 1) / 2;
  std::vector<double> course;
  double off = 0;
  for (const double share : unevenShares(out, dice)) {
    course.push_back(off += share);
  }
  for (const double share : unevenShares(frames - out, dice)) {
    course.push_back(off -= share);
  }
  course.back() = stays ? 1.0 : 0.0;
  return course;
}

/// The frames' errors, body frame: what a pose is off by from where its track would have it.
void addBurst(std::vector<Pose>& poses, std::size_t middle, bool stays, FaultDice dice) {
  const std::vector<double> course = burstCourse(stays, dice);
  const double yaw = dice.sign() * kBurst_deg * kDegree, way = dice.between(kBurst_m_min, kBurst_m_max);
  const double side = dice.between(0, kTau);
  const std::size_t first = middle - course.size() / 2;
  for (std::size_t i = 0; i < course.size(); ++i) {
    poses[first + i] = poses[first + i] *
                       planarStep(course[i] * way * std::cos(side), course[i] * way * std::sin(side), course[i] * yaw);
  }
  if (!stays) {
    return;
  }
  const std::size_t last = first + course.size() - 1;
  const Pose error = planarStep(way * std::cos(side), way * std::sin(side), yaw);
  const Pose T_off_odom = poses[last] * (poses[last] * error.inverse()).inverse();
  for (std::size_t i = last + 1; i < poses.size(); ++i) {
    poses[i] = T_off_odom * poses[i];
  }
}

// ---------------------------------------------------------------------------------------------------- at a time

/// One fault with its size, at the frames' times.
struct Fault {
  FaultKind kind;
  double from, until;  // s; a fault of one step: from == until
  double size;         // m, rad or share; signed
  double side;         // rad, of a jump
};

Fault withSize(const TimedFault& fault, FaultDice dice) {
  const double side = dice.between(0, kTau), sign = dice.sign();
  switch (fault.kind) {
    case FaultKind::kJump:
      return {fault.kind, fault.time, fault.time, fault.size.value_or(dice.between(4, 8)), side};
    case FaultKind::kYawJump:
      return {fault.kind, fault.time, fault.time, sign * kDegree * fault.size.value_or(dice.between(30, 120)), side};
    case FaultKind::kSlip:
      return {fault.kind, fault.time, fault.time + kFaultSeconds, fault.size.value_or(sign < 0 ? 0.4 : 1.6), side};
    case FaultKind::kFrozen:
      return {fault.kind, fault.time, fault.time + fault.size.value_or(kFaultSeconds), 0, side};
    case FaultKind::kRestart:
      break;
  }
  return {fault.kind, fault.time, fault.time, 0, side};
}

/// The step that ends at `time`, the one before it having ended at `before`.
Pose faultyStep(Pose step, const Fault& fault, double before, double time) {
  constexpr double kRounding = 1e-9;  // s
  const bool is_first = before < fault.from - kRounding && time >= fault.from - kRounding;
  const bool is_during = time > fault.from + kRounding && time < fault.until + kRounding;
  if (fault.kind == FaultKind::kJump && is_first) {
    return step * planarStep(fault.size * std::cos(fault.side), fault.size * std::sin(fault.side), 0);
  }
  if (fault.kind == FaultKind::kYawJump && is_first) {
    return step * planarStep(0, 0, fault.size);
  }
  if (fault.kind == FaultKind::kSlip && is_during) {
    step.translation() *= fault.size;
  }
  return fault.kind == FaultKind::kFrozen && is_during ? Pose::Identity() : step;
}

std::vector<Pose> withTimedFaults(const std::vector<Pose>& poses, const std::vector<double>& times,
                                  const std::vector<Fault>& faults) {
  std::vector<Pose> out{poses.front()};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    Pose step = poses[i - 1].inverse() * poses[i];
    bool restarts = false;
    for (const Fault& fault : faults) {
      step = faultyStep(step, fault, times[i - 1], times[i]);
      restarts = restarts || (fault.kind == FaultKind::kRestart && times[i - 1] < fault.from && times[i] >= fault.from);
    }
    out.push_back(restarts ? Pose::Identity() : out.back() * step);
  }
  return out;
}

Pose inWrongOrder(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  Pose out = T;
  out.linear() = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix();  // read as w, x, y, z
  return out;
}

}  // namespace

Result<TimedFault> parseFault(const std::string& text) {
  using Parsed = Result<TimedFault>;
  const std::string wanted = text + ": write KIND[:SIZE]@SECONDS, KIND one of jump, yaw-jump, slip, frozen, restart";
  const std::size_t at = text.find('@'), colon = text.find(':');
  if (at == std::string::npos) {
    return Parsed::fail(wanted);
  }
  const std::string name = text.substr(0, std::min(at, colon));
  const auto* const kind = std::ranges::find_if(kKindNames, [&](const KindName& known) { return known.name == name; });
  const auto time = numberIn(text.substr(at + 1));
  if (kind == kKindNames.end() || !time || *time < 0) {
    return Parsed::fail(wanted);
  }
  TimedFault fault{kind->kind, *time, std::nullopt};
  if (colon < at) {
    fault.size = numberIn(text.substr(colon + 1, at - colon - 1));
    if (!fault.size || *fault.size <= 0 || fault.kind == FaultKind::kRestart) {
      return Parsed::fail(wanted);
    }
  }
  return Parsed::ok(fault);
}

std::vector<Pose> withFaults(const std::vector<Pose>& T_odom_body, double rate_hz, const std::vector<std::size_t>& kept,
                             const OdometryFaults& faults, std::uint64_t seed) {
  std::vector<Pose> poses;
  std::vector<double> times;
  for (const std::size_t frame : kept) {
    times.push_back(static_cast<double>(frame) / rate_hz);
    poses.push_back(faults.delay == 0 ? T_odom_body[frame]
                                      : poseAtFrame(T_odom_body, static_cast<double>(frame) - faults.delay * rate_hz));
  }
  if (faults.bursts > 0 && times.size() > 1) {
    const double kept_hz = 1.0 / (times[1] - times[0]);
    const auto turns = sharpestTurns(poses, kept_hz, faults.bursts);
    for (std::size_t i = 0; i < turns.size(); ++i) {
      addBurst(poses, turns[i], faults.bursts_stay, FaultDice(seed, kBurstDice, i));
    }
  }
  std::vector<Fault> timed;
  for (std::size_t i = 0; i < faults.timed.size(); ++i) {
    timed.push_back(withSize(faults.timed[i], FaultDice(seed, kTimedDice, i)));
  }
  if (!timed.empty()) {
    poses = withTimedFaults(poses, times, timed);
  }
  if (faults.quaternion_xyzw) {
    std::ranges::transform(poses, poses.begin(), inWrongOrder);
  }
  return poses;
}

}  // namespace hgg
