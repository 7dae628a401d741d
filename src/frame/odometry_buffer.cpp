#include "frame/odometry_buffer.h"

#include <algorithm>

namespace hgg {

bool OdometryBuffer::add(const OdometrySample& sample) {
  if (!isAhead(sample.utime_us)) {
    if (samples_.back().utime_us - sample.utime_us <= kRestart_us) {
      ++rejected_;
      return false;
    }
    samples_.clear();
  }
  samples_.push_back(sample);
  if (samples_.size() > capacity_) {
    samples_.pop_front();
  }
  return true;
}

std::optional<Pose> OdometryBuffer::at(Micros utime_us) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), utime_us,
                                      [](const OdometrySample& s, Micros t) { return s.utime_us < t; });
  if (after == samples_.end()) {
    return std::nullopt;
  }
  if (after->utime_us == utime_us) {
    return after->T_odom_body;
  }
  if (after == samples_.begin()) {
    return std::nullopt;
  }
  const auto before = std::prev(after);
  const Micros gap_us = after->utime_us - before->utime_us;
  if (gap_us > kMaxOdometryGap_us) {
    return std::nullopt;
  }
  const double s = static_cast<double>(utime_us - before->utime_us) / static_cast<double>(gap_us);
  return interpolate(before->T_odom_body, after->T_odom_body, s);
}

Pose interpolate(const Pose& a, const Pose& b, double s) {
  const Eigen::Quaterniond q_a(a.linear()), q_b(b.linear());
  Pose out = Pose::Identity();
  out.linear() = q_a.slerp(s, q_b).normalized().toRotationMatrix();
  out.translation() = (1 - s) * a.translation() + s * b.translation();
  return out;
}

}  // namespace hgg
