#include "sim/worlds/way.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

constexpr double kStep = 0.05;  // m
/// Three passes of a moving average come close to a Gaussian: smooth up to the second derivative.
constexpr int kPasses = 3;

std::vector<Vec2> resample(const std::vector<Vec2>& corners) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& from = corners[i];
    const Vec2 side = corners[(i + 1) % corners.size()] - from;
    const double steps = std::max(1.0, std::round(side.norm() / kStep));
    for (double k = 0; k < steps; ++k) {
      points.emplace_back(from + side * (k / steps));
    }
  }
  return points;
}

/// Each value of a closed row becomes the mean of the `2 * reach + 1` around it.
template <typename Value>
std::vector<Value> averaged(const std::vector<Value>& points, std::size_t reach) {
  const std::size_t n = points.size();
  Value sum = points[0];
  for (std::size_t k = 1; k <= reach; ++k) {
    sum += points[k % n] + points[(n - k % n) % n];
  }
  std::vector<Value> result;
  result.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.emplace_back(sum / static_cast<double>(2 * reach + 1));
    sum += points[(i + reach + 1) % n] - points[(i + n - reach % n) % n];
  }
  return result;
}

double lengthOf(const std::vector<Vec2>& points) {
  double length = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    length += (points[(i + 1) % points.size()] - points[i]).norm();
  }
  return length;
}

/// The closed line through `points` again, with `count` points at equal distances.
std::vector<Vec2> evenly(const std::vector<Vec2>& points, std::size_t count) {
  const double spacing = lengthOf(points) / static_cast<double>(count);
  std::vector<Vec2> result;
  double passed = 0;
  for (std::size_t i = 0; i < points.size() && result.size() < count; ++i) {
    const Vec2 side = points[(i + 1) % points.size()] - points[i];
    const double length = side.norm();
    while (result.size() < count && spacing * static_cast<double>(result.size()) < passed + length) {
      result.emplace_back(points[i] + side * ((spacing * static_cast<double>(result.size()) - passed) / length));
    }
    passed += length;
  }
  return result;
}

std::vector<double> speedLimits(const Way& way, double speed, double turn_rate) {
  std::vector<double> limits;
  limits.reserve(way.points().size());
  for (std::size_t i = 0; i < way.points().size(); ++i) {
    const double curvature = std::abs(way.at(static_cast<double>(i) * way.spacing()).curvature);
    limits.push_back(std::min(speed, turn_rate / std::max(curvature, 1e-9)));
  }
  return limits;
}

/// Each value of a closed row becomes the lowest of the `2 * reach + 1` around it: a mean over as many stays below it.
std::vector<double> lowest(const std::vector<double>& values, std::size_t reach) {
  const std::size_t n = values.size();
  std::vector<double> result = values;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 1; k <= reach; ++k) {
      result[i] = std::min({result[i], values[(i + k) % n], values[(i + n - k % n) % n]});
    }
  }
  return result;
}

}  // namespace

Way::Way(const std::vector<Vec2>& corners, double rounding) {
  std::vector<Vec2> points = resample(corners);
  const auto reach = static_cast<std::size_t>(std::round(rounding / (2.0 * kPasses * kStep)));
  for (int pass = 0; pass < kPasses; ++pass) {
    points = averaged(points, reach);
  }
  const double length = lengthOf(points);
  points_ = evenly(points, static_cast<std::size_t>(std::round(length / kStep)));
  spacing_ = length / static_cast<double>(points_.size());
}

const Vec2& Way::point(std::ptrdiff_t i) const {
  const auto n = static_cast<std::ptrdiff_t>(points_.size());
  return points_[static_cast<std::size_t>(((i % n) + n) % n)];
}

WayPoint Way::at(double s) const {
  const double index = std::floor(s / spacing_), share = s / spacing_ - index;
  const auto i = static_cast<std::ptrdiff_t>(index);
  // Differences over a few points at both ends, blended: continuous in s.
  constexpr std::ptrdiff_t kReach = 4;
  const auto tangent = [&](std::ptrdiff_t k) { return Vec2((point(k + kReach) - point(k - kReach)).normalized()); };
  const auto turned = [&](std::ptrdiff_t k) {
    const Vec2 before = tangent(k - kReach), after = tangent(k + kReach);
    return std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after)) / (2.0 * kReach * spacing_);
  };
  return {(1.0 - share) * point(i) + share * point(i + 1),
          ((1.0 - share) * tangent(i) + share * tangent(i + 1)).normalized(),
          (1.0 - share) * turned(i) + share * turned(i + 1)};
}

Journey::Journey(Way way, double speed, double turn_rate) : way_(std::move(way)), arrival_{0.0} {
  constexpr double kEase = 0.25;  // s of way over which speed changes, twice
  const auto reach = static_cast<std::size_t>(kEase * speed / kStep);
  const std::vector<double> limits = speedLimits(way_, speed, turn_rate);
  for (const double v : averaged(averaged(lowest(limits, 2 * reach), reach), reach)) {
    arrival_.push_back(arrival_.back() + way_.spacing() / v);
  }
}

double Journey::progress(double time) const {
  const double laps = std::floor(time / lapTime()), in_lap = time - laps * lapTime();
  const auto next = std::upper_bound(arrival_.begin(), arrival_.end() - 1, in_lap);
  const auto i = static_cast<std::size_t>(next - arrival_.begin()) - 1;
  const double share = (in_lap - arrival_[i]) / (arrival_[i + 1] - arrival_[i]);
  return laps * way_.length() + (static_cast<double>(i) + share) * way_.spacing();
}

double Journey::timeAt(double s) const {
  const double index = std::clamp(s / way_.spacing(), 0.0, static_cast<double>(arrival_.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(index), arrival_.size() - 2);
  return arrival_[i] + (index - static_cast<double>(i)) * (arrival_[i + 1] - arrival_[i]);
}

}  // namespace hgg
