#include "frame/motion.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

/// Between poses so far apart a body's motion is a straight line, and a small turn the mean of its ends: at a turn of
/// 180 degrees a second a point 50 m away is off by 1.5 mm.
constexpr double kKnot_s = 0.005;
constexpr std::size_t kMostKnots = 256;
constexpr float kLongest = 0.5F;  // s from a cloud's time

using Rows = Eigen::Matrix<float, 3, 4>;

void apply(const Rows& T, Point& p) {
  const Eigen::Vector3f moved = T * Eigen::Vector4f(p.x, p.y, p.z, 1.0F);
  p.x = moved.x(), p.y = moved.y(), p.z = moved.z();
}

/// T_to_from at evenly spaced times from `first` to `last`, s after `utime_us`; empty where odometry does not tell.
std::vector<Rows> knots(double first, double last, Micros utime_us, Micros to_us, const OdometryBuffer& odometry,
                        Micros delay_us) {
  const auto count = std::min(kMostKnots, static_cast<std::size_t>(std::ceil((last - first) / kKnot_s)) + 1);
  std::vector<Rows> out;
  for (std::size_t k = 0; k < count; ++k) {
    const double t =
        count == 1 ? first : first + (last - first) * static_cast<double>(k) / static_cast<double>(count - 1);
    const auto T = motionBetween(odometry, utime_us + std::llround(1e6 * t), to_us, delay_us);
    if (!T) {
      return {};
    }
    out.emplace_back(T->matrix().topRows<3>().cast<float>());
  }
  return out;
}

/// A time that says more than a scan can take means something else.
float believed(float t) { return std::abs(t) <= kLongest ? t : 0.0F; }

}  // namespace

void moveToBody(SemanticCloud& cloud, const Pose& T_body_sensor) {
  if (T_body_sensor.matrix() != Pose::Identity().matrix()) {
    const Eigen::Isometry3f T = T_body_sensor.cast<float>();
    for (Point& p : cloud.points) {
      const Eigen::Vector3f v = T * Eigen::Vector3f(p.x, p.y, p.z);
      p.x = v.x(), p.y = v.y(), p.z = v.z();
    }
  }
  cloud.p_body_sensor = T_body_sensor.translation();
}

std::optional<Pose> motionBetween(const OdometryBuffer& odometry, Micros from_us, Micros to_us, Micros delay_us) {
  const auto from = odometry.around(from_us + delay_us, kMotionReach_us);
  const auto to = odometry.around(to_us + delay_us, kMotionReach_us);
  if (!from || !to || from->stretch != to->stretch) {
    return std::nullopt;
  }
  return to->T_odom_body.inverse() * from->T_odom_body;
}

bool movePoints(std::span<Point> points, std::span<const float> times, Micros utime_us, Micros to_us,
                const OdometryBuffer& odometry, Micros delay_us) {
  float first = 0, last = 0;
  if (!times.empty()) {
    first = kLongest, last = -kLongest;
    for (const float t : times) {
      first = std::min(first, believed(t)), last = std::max(last, believed(t));
    }
  }
  const std::vector<Rows> T = knots(first, last, utime_us, to_us, odometry, delay_us);
  if (T.empty()) {
    return false;
  }
  const float per_knot = last > first ? static_cast<float>(T.size() - 1) / (last - first) : 0.0F;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float at = times.empty() ? 0.0F : (believed(times[i]) - first) * per_knot;
    const std::size_t k = std::min(static_cast<std::size_t>(at), T.size() - 1);
    const float s = at - static_cast<float>(k);
    apply(k + 1 < T.size() ? Rows((1 - s) * T[k] + s * T[k + 1]) : T[k], points[i]);
  }
  return true;
}

bool deskew(Frame& frame, const OdometryBuffer& odometry, Micros delay_us) {
  const bool moved =
      frame.times.empty() || movePoints(frame.points, frame.times, frame.utime_us, frame.utime_us, odometry, delay_us);
  frame.times.clear();
  return moved;
}

}  // namespace hgg
