#pragma once

#include <vector>

#include "core/types.h"

namespace hgg {

using Vec2 = Eigen::Vector2d;

/// Where and how far a way has come.
struct WayPoint {
  Vec2 position;
  Vec2 along;            // unit direction of travel
  double curvature = 0;  // 1/m, positive to the left
};

/// A closed way through corners, rounded to be smooth: its direction and curvature have no jumps.
class Way {
 public:
  /// `rounding`: m of way over which a corner is spread.
  Way(const std::vector<Vec2>& corners, double rounding);

  double length() const { return spacing_ * static_cast<double>(points_.size()); }
  /// At `s` m along the way; any s, it wraps.
  WayPoint at(double s) const;
  /// Points of the way, about `spacing()` apart.
  const std::vector<Vec2>& points() const { return points_; }
  double spacing() const { return spacing_; }

 private:
  const Vec2& point(std::ptrdiff_t i) const;

  std::vector<Vec2> points_;
  double spacing_ = 0;
};

/// A journey along a way at `speed` m/s on the straight, slowed in bends so that it turns at no more than `turn_rate`
/// rad/s.
class Journey {
 public:
  Journey(Way way, double speed, double turn_rate);

  const Way& way() const { return way_; }
  double lapTime() const { return arrival_.back(); }
  /// m along the way after `time` s, laps included.
  double progress(double time) const;
  /// When the travel first comes by `s` m, 0 <= s <= length.
  double timeAt(double s) const;

 private:
  Way way_;
  std::vector<double> arrival_;  // s, at each point of the way and at the end of the lap
};

}  // namespace hgg
