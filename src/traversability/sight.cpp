#include "traversability/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"
#include "traversability/edges.h"

namespace hgg {
namespace {

/// Two places nearer to each other than this see the same. m
constexpr double kApart = 0.25;
/// The sensor went straight between keyframes that are nearer to each other. m
constexpr double kLongestStride = 3;
/// Farther off, beams are so sparse that they tell little about what stands on the ground. m
constexpr double kFarthest = 15;
/// Places that are tried for one cell.
constexpr std::size_t kMostEyes = 64;
/// Edge of the squares whose cells share their list of places. m
constexpr double kBlock = 2;
/// By this much of a cell a surface may rise between the middles of two columns, beyond what its leaves say of each: a
/// line must not slip between them.
constexpr double kSlant = 0.25;
/// Where in the space of the body the eye has to get to, as a share of the body's height: where its trunk is.
constexpr double kTrunk = 0.6;
/// What hangs may go on this far from where it was seen: half of what a large sign or a table measures across. m
constexpr double kHalfHanging = 1;

/// The way of the sensor from keyframe to keyframe, map frame, with places in between.
std::vector<Vec3> wayOf(const MapLeaves& map) {
  std::vector<Vec3> way;
  for (const TimedPose& pose : map.keyframes) {
    const Vec3 p = pose.T_map_body.translation();
    const Vec3 from = way.empty() ? p : way.back();
    const double stride = (p - from).norm();
    const int steps = stride < kLongestStride ? static_cast<int>(stride / kApart) : 0;
    for (int k = 1; k <= steps; ++k) {
      way.push_back(from + (p - from) * k / (steps + 1));
    }
    way.push_back(p);
  }
  return way;
}

}  // namespace

Eyes::Eyes(const MapLeaves& map, const GridShape& shape) {
  for (const Vec3& p : wayOf(map)) {
    const double dx = std::max({shape.x - p.x(), p.x() - shape.x - shape.width * shape.resolution, 0.0});
    const double dy = std::max({shape.y - p.y(), p.y() - shape.y - shape.height * shape.resolution, 0.0});
    const auto is_near = [&](const Vec3& other) { return (other - p).squaredNorm() < square(kApart); };
    if (std::hypot(dx, dy) < kFarthest && std::ranges::none_of(all_, is_near)) {
      all_.push_back(p);
    }
  }
  cells_per_block_ = std::max(1, static_cast<std::int32_t>(kBlock / shape.resolution));
  blocks_wide_ = (shape.width - 1) / cells_per_block_ + 1;
  std::vector<std::pair<double, std::uint32_t>> by_distance;  // m, index in all_
  for (std::int32_t row = 0; row < shape.height; row += cells_per_block_) {
    for (std::int32_t column = 0; column < shape.width; column += cells_per_block_) {
      const double x = shape.xOf(column + cells_per_block_ / 2), y = shape.yOf(row + cells_per_block_ / 2);
      by_distance.clear();
      for (std::uint32_t k = 0; k < all_.size(); ++k) {
        const double distance = std::hypot(all_[k].x() - x, all_[k].y() - y);
        if (distance < kFarthest) {
          by_distance.emplace_back(distance, k);
        }
      }
      const std::size_t count = std::min(by_distance.size(), kMostEyes);
      std::ranges::partial_sort(by_distance, by_distance.begin() + static_cast<std::ptrdiff_t>(count));
      const auto begin = static_cast<std::uint32_t>(near_.size());
      for (std::size_t k = 0; k < count; ++k) {
        near_.push_back(all_[by_distance[k].second]);
      }
      blocks_.push_back({begin, static_cast<std::uint32_t>(near_.size())});
    }
  }
}

std::span<const Vec3> Eyes::around(std::int32_t column, std::int32_t row) const {
  const std::int32_t block = row / cells_per_block_ * blocks_wide_ + column / cells_per_block_;
  const Block& b = blocks_[static_cast<std::size_t>(block)];
  return std::span(near_).subspan(b.begin, b.end - b.begin);
}

SightLines::SightLines(const CostGrid& grid, const MapLeaves& map) : grid_(grid), eyes_(map, grid.shape) {
  gaps_.resize(static_cast<std::size_t>(grid.shape.cells()));
  for (std::int32_t cell = 0; cell < grid.shape.cells(); ++cell) {
    const std::span<const Support> column = grid.column(cell);
    Gap& gap = gaps_[static_cast<std::size_t>(cell)];
    gap.low = column.empty() ? gap.low : column[0].top;
    gap.high = column.size() < 2 ? gap.high : column[1].bottom;
  }
}

bool SightLines::isInSight(const Vec3& p_map, const Vec3& p_eye) const {
  const GridShape& shape = grid_.shape;
  const Vec3 line = p_eye - p_map;
  // Half a cell at a time: no corner of a wall is jumped over.
  const int steps = static_cast<int>(2 * std::hypot(line.x(), line.y()) / shape.resolution);
  const double rise = line.z() / std::max(steps, 1), half_rise = std::abs(rise) / 2 + kSlant * shape.resolution;
  // In cells from the corner of the grid.
  const double dx = line.x() / (std::max(steps, 1) * shape.resolution),
               dy = line.y() / (std::max(steps, 1) * shape.resolution);
  double x = p_map.x() / shape.resolution - shape.first_column, y = p_map.y() / shape.resolution - shape.first_row;
  double z = p_map.z();
  std::int32_t last = shape.cell(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
  for (int k = 1; k < steps; ++k) {
    x += dx, y += dy, z += rise;
    if (x < 0 || y < 0 || x >= shape.width || y >= shape.height) {
      return true;
    }
    const std::int32_t cell = shape.cell(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
    const Gap& gap = gaps_[static_cast<std::size_t>(cell)];
    if (cell == last || (z - half_rise > gap.low && z + half_rise < gap.high)) {
      continue;
    }
    last = -1;
    if (std::ranges::any_of(grid_.column(cell),
                            [&](const Support& s) { return s.bottom <= z + half_rise && z - half_rise <= s.top; })) {
      return false;
    }
  }
  return true;
}

void SightLines::appendHanging(std::int32_t column, std::int32_t row, const Support& ground,
                               const TraversabilityConfig& limits, std::vector<double>& heights) const {
  const double low = ground.height + limits.step_height, high = ground.height + limits.body_height;
  for (const Support& s : grid_.column(grid_.shape.cell(column, row))) {
    if (s.bottom > low && s.bottom < high) {
      heights.push_back((s.bottom + std::min<double>(s.top, high)) / 2);
    }
  }
}

std::vector<double> SightLines::hangingAround(std::int32_t column, std::int32_t row, const Support& ground,
                                              const TraversabilityConfig& limits) const {
  const GridShape& shape = grid_.shape;
  const int reach = static_cast<int>(kHalfHanging / shape.resolution);
  std::vector<double> heights;
  for (const auto& [dx, dy] : kWays) {
    for (int k = 1; k <= reach && shape.contains(column + k * dx, row + k * dy); ++k) {
      const std::size_t before = heights.size();
      if (std::isfinite(gaps_[static_cast<std::size_t>(shape.cell(column + k * dx, row + k * dy))].high)) {
        appendHanging(column + k * dx, row + k * dy, ground, limits, heights);
      }
      if (heights.size() > before) {
        break;
      }
    }
  }
  return heights;
}

bool SightLines::isHidden(std::int32_t column, std::int32_t row, const Support& ground,
                          const TraversabilityConfig& limits) const {
  const std::span<const Vec3> around = eyes_.around(column, row);
  const auto nobody_sees = [&](double height) {
    const Vec3 p(grid_.shape.xOf(column), grid_.shape.yOf(row), height);
    return std::ranges::none_of(around, [&](const Vec3& p_eye) { return isInSight(p, p_eye); });
  };
  return !around.empty() && (nobody_sees(ground.height + kTrunk * limits.body_height) ||
                             std::ranges::any_of(hangingAround(column, row, ground, limits), nobody_sees));
}

std::uint8_t sightOn(const SightLines& sight, std::int32_t column, std::int32_t row, const Support& s,
                     const TraversabilityConfig& limits) {
  const bool is_edge = endsInView(sight, column, row, s, limits);
  const bool is_hidden = isWalkable(s.cost) && sight.isHidden(column, row, s, limits);
  return static_cast<std::uint8_t>((is_edge ? kEdge : 0) | (is_hidden ? kHidden : 0));
}

std::vector<std::uint8_t> sightOn(const SightLines& sight, const TraversabilityConfig& limits,
                                  const ShareDone& progress) {
  const CostGrid& grid = sight.grid();
  std::vector<std::uint8_t> seen;
  seen.reserve(grid.supports.size());
  for (std::int32_t row = 0; row < grid.shape.height; ++row) {
    for (std::int32_t column = 0; column < grid.shape.width; ++column) {
      for (const Support& s : grid.column(grid.shape.cell(column, row))) {
        seen.push_back(sightOn(sight, column, row, s, limits));
      }
    }
    if (progress) {
      progress((row + 1.0) / grid.shape.height);
    }
  }
  return seen;
}

void applySight(const std::vector<std::uint8_t>& sight, const WalkedWay& walked, const TraversabilityConfig& limits,
                CostGrid& grid) {
  blockBeforeEdges(sight, walked, limits, grid);
  for (std::int32_t cell = 0; cell < grid.shape.cells(); ++cell) {
    for (std::uint32_t k = grid.first[static_cast<std::size_t>(cell)];
         k < grid.first[static_cast<std::size_t>(cell) + 1]; ++k) {
      Support& s = grid.supports[k];
      if ((sight[k] & kHidden) != 0 && isWalkable(s.cost) && !wasWalkedOn(walked, grid, cell, s)) {
        s.cost = kCostUnknown;
      }
    }
  }
}

}  // namespace hgg
