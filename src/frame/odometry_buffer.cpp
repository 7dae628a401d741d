#include "frame/odometry_buffer.h"

#include <algorithm>
#include <iterator>

namespace hgg {
namespace {

constexpr Micros kSilence_us = 1'000'000, kSilentIntervals = 5;

}  // namespace

void OdometryBuffer::add(const OdometrySample& sample) {
  const StampVerdict verdict = judge_.judge(sample.utime_us);
  if (verdict == StampVerdict::kLate) {
    ++counts_.late;
    return;
  }
  if (verdict == StampVerdict::kConfirms) {
    takeApart();
  }
  counts_.outliers += apart_ ? 1 : 0;
  apart_.reset();
  if (verdict == StampVerdict::kApart) {
    apart_ = sample;
  } else {
    take(sample);
  }
}

void OdometryBuffer::finish() {
  if (judge_.believesTheLast()) {
    takeApart();
  }
  counts_.outliers += apart_ ? 1 : 0;
  apart_.reset();
}

void OdometryBuffer::takeApart() {
  const StampStep step = judge_.step();
  if (step == StampStep::kWentBack) {
    samples_.clear();
  }
  counts_.anew += step == StampStep::kSteady ? 0 : 1;
  take(*apart_);
  apart_.reset();
}

void OdometryBuffer::take(const OdometrySample& sample) {
  samples_.push_back({sample, counts_.anew});
  ++believed_;
  if (samples_.size() > capacity_) {
    samples_.pop_front();
  }
}

OdometryBuffer::Iterator OdometryBuffer::firstNotBefore(Micros utime_us) const {
  return std::lower_bound(samples_.begin(), samples_.end(), utime_us,
                          [](const Entry& e, Micros t) { return e.sample.utime_us < t; });
}

std::optional<OdometryPose> OdometryBuffer::at(Micros utime_us) const {
  const auto after = firstNotBefore(utime_us);
  if (after == samples_.end()) {
    return std::nullopt;
  }
  if (after->sample.utime_us == utime_us) {
    return OdometryPose{after->sample.T_odom_body, after->stretch};
  }
  if (after == samples_.begin()) {
    return std::nullopt;
  }
  const OdometrySample &a = std::prev(after)->sample, &b = after->sample;
  const Micros gap_us = b.utime_us - a.utime_us;
  if (gap_us > max_gap_us_) {
    return std::nullopt;
  }
  const double s = static_cast<double>(utime_us - a.utime_us) / static_cast<double>(gap_us);
  return OdometryPose{interpolate(a.T_odom_body, b.T_odom_body, s), after->stretch};
}

std::optional<OdometryPose> OdometryBuffer::around(Micros utime_us, Micros reach_us) const {
  if (auto pose = at(utime_us)) {
    return pose;
  }
  const bool is_ahead = missAt(utime_us) == OdometryMiss::kAhead;
  if (samples_.size() < 2 || missAt(utime_us) == OdometryMiss::kGap) {
    return std::nullopt;
  }
  const std::size_t first = is_ahead ? samples_.size() - 2 : 0;
  const Entry &a = samples_[first], &b = samples_[first + 1];
  const Micros gap_us = b.sample.utime_us - a.sample.utime_us;
  const Micros beyond_us = is_ahead ? utime_us - b.sample.utime_us : a.sample.utime_us - utime_us;
  if (gap_us > max_gap_us_ || beyond_us > reach_us || a.stretch != b.stretch) {
    return std::nullopt;
  }
  const double s = static_cast<double>(utime_us - a.sample.utime_us) / static_cast<double>(gap_us);
  return OdometryPose{interpolate(a.sample.T_odom_body, b.sample.T_odom_body, s), b.stretch};
}

OdometryMiss OdometryBuffer::missAt(Micros utime_us) const {
  if (samples_.empty() || utime_us > samples_.back().sample.utime_us) {
    return OdometryMiss::kAhead;
  }
  return utime_us < samples_.front().sample.utime_us ? OdometryMiss::kBefore : OdometryMiss::kGap;
}

Micros OdometryBuffer::gapAround_us(Micros utime_us) const {
  const auto after = firstNotBefore(utime_us);
  return after == samples_.end() || after == samples_.begin()
             ? 0
             : after->sample.utime_us - std::prev(after)->sample.utime_us;
}

bool OdometryBuffer::fellSilent(Micros from_us, Micros to_us) const {
  const Micros longest_us = std::max(kSilence_us, kSilentIntervals * judge_.usualInterval_us());
  for (auto it = firstNotBefore(from_us + 1); it != samples_.end() && it != samples_.begin(); ++it) {
    if (it->sample.utime_us - std::prev(it)->sample.utime_us > longest_us) {
      return true;
    }
    if (it->sample.utime_us >= to_us) {
      break;
    }
  }
  return false;
}

std::optional<Micros> OdometryBuffer::newest_us() const {
  return samples_.empty() ? std::nullopt : std::optional(samples_.back().sample.utime_us);
}

Pose interpolate(const Pose& a, const Pose& b, double s) {
  const Eigen::Quaterniond q_a(a.linear()), q_b(b.linear());
  Pose out = Pose::Identity();
  out.linear() = q_a.slerp(s, q_b).normalized().toRotationMatrix();
  out.translation() = (1 - s) * a.translation() + s * b.translation();
  return out;
}

}  // namespace hgg
