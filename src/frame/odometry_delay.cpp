#include "frame/odometry_delay.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/so3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr Micros kWindow_us = 1'000'000;
constexpr Micros kStep_us = 20'000, kFarthest_us = 500'000;  // of the candidate delays
constexpr std::size_t kCandidates = 2 * (kFarthest_us / kStep_us) + 1;
constexpr std::size_t kMostWaiting = 1000;  // turns whose odometry has not come: bounds memory
/// Share of the sums that each new window leaves of them: they remember some five minutes at 10 Hz. A clock drifts.
constexpr double kKeep = 0.9997;
/// A difference is counted as this much at most, rad: the map's frame turns when a loop is closed.
constexpr double kLargest = 10 * kDegree;
/// A window tells something when the turn that odometry shows depends on the delay by this much, rad.
constexpr double kTelling = 2 * kDegree;
/// A delay is applied when it is known this well, or when it is this many of its deviations from the present one:
/// wheels tell turns too poorly for the first. It also has to be better than the present one by this factor.
/// Interpolation between samples smooths odometry's noise, which alone makes a delay of half the time between samples
/// look better: so a change that small has to be much better.
constexpr double kSmoothedShare = 0.6, kMuchBetter = 4;  // of the time between samples; of the squared differences
constexpr double kKnown = 0.01, kCertain = 4;            // s, deviations
constexpr double kRefining = 2;                          // deviations, of a delay that was applied early
constexpr double kBetter = 1.4;                          // of the squared differences
constexpr Micros kWorthwhile_us = 15'000;                // smaller changes are not worth a change
constexpr double kFewest = 100;                          // windows
/// The deviation is multiplied by this, because differences are not independent as the sum of squares takes them to be.
constexpr double kCaution = 2;

Micros delayOf(std::size_t candidate) { return static_cast<Micros>(candidate) * kStep_us - kFarthest_us; }

}  // namespace

void OdometryDelay::add(Micros utime_us, const std::optional<Mat3>& R_last_body) {
  if (!window_.empty() && utime_us <= window_.back().utime_us) {
    waiting_.clear();  // their clock was set back: odometry of their time does not come any more
  }
  if (!R_last_body || window_.empty() || utime_us <= window_.back().utime_us ||
      utime_us - window_.back().utime_us > kWindow_us) {
    window_.clear();
    window_.push_back({utime_us, Mat3::Identity()});
    return;
  }
  window_.push_back({utime_us, window_.back().R * *R_last_body});
  while (utime_us - window_.front().utime_us > kWindow_us) {
    window_.pop_front();
  }
  per_window_ = std::max(1.0, static_cast<double>(window_.size()) - 1);
  if (2 * (utime_us - window_.front().utime_us) > kWindow_us) {
    const Mat3 turn = window_.front().R.transpose() * window_.back().R;
    waiting_.push_back({window_.front().utime_us, utime_us, logRotation(turn)});
  }
  if (waiting_.size() > kMostWaiting) {
    waiting_.pop_front();
  }
}

void OdometryDelay::compare(const OdometryBuffer& odometry) {
  const std::optional<Micros> newest_us = odometry.newest_us();
  interval_us_ = odometry.usualInterval_us();
  while (newest_us && !waiting_.empty() && waiting_.front().to_us + kFarthest_us <= *newest_us) {
    compare(waiting_.front(), odometry);
    waiting_.pop_front();
    decide();
  }
}

void OdometryDelay::compare(const Turn& turn, const OdometryBuffer& odometry) {
  std::vector<double> squares;
  std::vector<Vec3> turns;
  std::optional<std::int64_t> stretch;
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const auto from = odometry.at(turn.from_us + delayOf(k)), to = odometry.at(turn.to_us + delayOf(k));
    if (!from || !to || from->stretch != to->stretch || from->stretch != stretch.value_or(from->stretch)) {
      return;  // a fair comparison needs all of them
    }
    stretch = from->stretch;
    const Mat3 by_odometry = from->T_odom_body.linear().transpose() * to->T_odom_body.linear();
    turns.push_back(logRotation(by_odometry));
    squares.push_back(square(std::min(kLargest, (turn.turn - turns.back()).norm())));
  }
  const auto isOther = [&](const Vec3& other) { return (other - turns.front()).norm() > kTelling; };
  if (std::ranges::none_of(turns, isOther)) {
    return;
  }
  squares_.resize(kCandidates, 0);
  for (std::size_t k = 0; k < kCandidates; ++k) {
    squares_[k] = kKeep * squares_[k] + squares[k];
  }
  count_ = kKeep * count_ + 1;
}

std::optional<OdometryDelay::Estimate> OdometryDelay::estimate() const {
  if (count_ < kFewest) {
    return std::nullopt;
  }
  const auto least = static_cast<std::size_t>(std::ranges::min_element(squares_) - squares_.begin());
  if (least == 0 || least + 1 == kCandidates) {
    return std::nullopt;  // it lies beyond
  }
  const double before = squares_[least - 1], at = squares_[least], after = squares_[least + 1];
  const double bend = before - 2 * at + after;  // of the parabola through the three, per step^2
  if (!(bend > 0)) {
    return std::nullopt;
  }
  const double step = 1e-6 * static_cast<double>(kStep_us);
  const double variance = at / (3 * count_) * per_window_;  // of a turn, rad^2 per axis; windows overlap
  const double delay = 1e-6 * static_cast<double>(delayOf(least)) + 0.5 * step * (before - after) / bend;
  return Estimate{delay, kCaution * step * std::sqrt(2 * variance / bend)};
}

void OdometryDelay::decide() {
  const auto found = estimate();
  if (!found) {
    return;
  }
  const auto estimate_us = static_cast<Micros>(std::llround(1e6 * found->delay));
  const Micros delay_us = std::abs(estimate_us) < kWorthwhile_us ? 0 : estimate_us;
  const auto present = static_cast<std::size_t>((applied_us_ + kFarthest_us + kStep_us / 2) / kStep_us);
  const Micros change_us = std::abs(delay_us - applied_us_);
  const double deviations = 1e-6 * static_cast<double>(change_us) / found->sigma;
  const bool refines = applied_us_ != 0 && deviations > kRefining;
  if (found->sigma > kKnown && deviations < kCertain && !refines) {
    return;
  }
  const double better =
      static_cast<double>(change_us) < kSmoothedShare * static_cast<double>(interval_us_) ? kMuchBetter : kBetter;
  const bool is_better = squares_[present] > better * *std::ranges::min_element(squares_);
  if (change_us > kWorthwhile_us && (is_better || refines)) {
    applied_us_ = delay_us;
  }
}

}  // namespace hgg
