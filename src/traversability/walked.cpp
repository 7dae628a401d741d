#include "traversability/walked.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace hgg {
namespace {

/// Keyframes farther apart, or with more time between them, tell nothing of the way: the robot may have been carried.
constexpr double kLongestStride = 3;         // m
constexpr Micros kLongestPause = 5'000'000;  // us
/// The ground may lie off the straight line between keyframes by this much, at the foot of a ramp. m
constexpr double kSag = 0.35;
/// The body's height is no better known, and so stays the same while the map grows. m
constexpr double kRounding = 0.05;

/// Height of the body above the ground: the median over the keyframes of the grid that have ground below them.
std::optional<double> bodyAboveGround(const MapLeaves& map, const CostGrid& grid) {
  std::vector<double> heights;
  for (const TimedPose& pose : map.keyframes) {
    const Vec3 p = pose.T_map_body.translation();
    const std::int32_t column = grid.shape.columnOf(p.x()), row = grid.shape.rowOf(p.y());
    if (!grid.shape.contains(column, row)) {
      continue;
    }
    double lowest = std::numeric_limits<double>::infinity();
    for (const Support& s : grid.column(grid.shape.cell(column, row))) {
      lowest = s.carries && s.height < p.z() ? std::min(lowest, p.z() - s.height) : lowest;
    }
    if (std::isfinite(lowest)) {
      heights.push_back(lowest);
    }
  }
  if (heights.empty()) {
    return std::nullopt;
  }
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::ranges::nth_element(heights, middle);
  return kRounding * std::round(*middle / kRounding);
}

void markFootprint(const GridShape& shape, const Vec3& p_feet, double radius, WalkedWay& way) {
  const auto reach = static_cast<std::int32_t>(radius / shape.resolution);
  const std::int32_t column = shape.columnOf(p_feet.x()), row = shape.rowOf(p_feet.y());
  for (std::int32_t r = row - reach; r <= row + reach; ++r) {
    for (std::int32_t c = column - reach; c <= column + reach; ++c) {
      if (shape.contains(c, r) && std::hypot(c - column, r - row) * shape.resolution <= radius) {
        way.height[static_cast<std::size_t>(shape.cell(c, r))] = static_cast<float>(p_feet.z());
      }
    }
  }
  if (shape.contains(column, row)) {
    way.is_core[static_cast<std::size_t>(shape.cell(column, row))] = 1;
  }
}

}  // namespace

WalkedWay walkedWayOf(const MapLeaves& map, const CostGrid& grid, const TraversabilityConfig& limits) {
  const auto cells = static_cast<std::size_t>(grid.shape.cells());
  WalkedWay way{std::vector<float>(cells, std::numeric_limits<float>::quiet_NaN()),
                std::vector<std::uint8_t>(cells, 0)};
  const std::optional<double> above = bodyAboveGround(map, grid);
  const std::vector<TimedPose>& poses = map.keyframes;
  for (std::size_t k = 1; above && k < poses.size(); ++k) {
    const Vec3 from = poses[k - 1].T_map_body.translation(), to = poses[k].T_map_body.translation();
    const double stride = (to - from).norm();
    if (stride > kLongestStride || poses[k].utime_us - poses[k - 1].utime_us > kLongestPause) {
      continue;
    }
    const int steps = 1 + static_cast<int>(2 * stride / grid.shape.resolution);
    for (int i = 0; i <= steps; ++i) {
      markFootprint(grid.shape, from + (to - from) * i / steps - *above * Vec3::UnitZ(), limits.footprint_radius, way);
    }
  }
  return way;
}

bool wasWalkedOn(const WalkedWay& way, const CostGrid& grid, std::int32_t cell, const Support& s) {
  if (!way.isOn(cell)) {
    return false;
  }
  const float feet = way.height[static_cast<std::size_t>(cell)];
  const double distance = std::abs(s.height - feet);
  return distance <= kSag && std::ranges::none_of(grid.column(cell), [&](const Support& other) {
           return std::abs(other.height - feet) < distance;
         });
}

}  // namespace hgg
