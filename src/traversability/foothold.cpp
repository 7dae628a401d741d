#include "traversability/foothold.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace hgg {
namespace {

/// A metre of the worst ground costs as much as this many of good ground: the robot takes no longer way around it.
constexpr double kWorstFactor = 3;

/// True when a blocked surface concerns a robot that stands beside it at `height`: it is ground there, or stands or
/// hangs where the body is.
bool isInTheWay(const Support& blocked, double height, const TraversabilityConfig& limits) {
  return std::abs(blocked.height - height) <= limits.step_height ||
         (blocked.bottom < height + limits.body_height && blocked.top > height + limits.step_height);
}

}  // namespace

Footholds::Footholds(const CostGrid& grid, const TraversabilityConfig& limits)
    : grid_(grid), step_height_(limits.step_height) {
  cell_of_.reserve(grid.supports.size());
  clear_.reserve(grid.supports.size());
  const GridShape& shape = grid.shape;
  for (std::int32_t cell = 0; cell < shape.cells(); ++cell) {
    for (const Support& s : grid.column(cell)) {
      cell_of_.push_back(cell);
      clear_.push_back(isWalkable(s.cost) ? 1 : 0);
    }
  }
  // From the middle of the robot's cell to the middle of that in which something stands, on its near half.
  const double radius = std::max(0.0, limits.footprint_radius - shape.resolution / 2) / shape.resolution;  // cells
  const auto reach = static_cast<std::int32_t>(radius);
  for (std::uint32_t k = 0; k < cell_of_.size(); ++k) {
    if (grid.supports[k].cost != kCostBlocked) {
      continue;
    }
    const std::int32_t column = cell_of_[k] % shape.width, row = cell_of_[k] / shape.width;
    for (std::int32_t dr = -reach; dr <= reach; ++dr) {
      for (std::int32_t dc = -reach; dc <= reach; ++dc) {
        if (dr * dr + dc * dc > radius * radius || !shape.contains(column + dc, row + dr)) {
          continue;
        }
        const auto cell = static_cast<std::size_t>(shape.cell(column + dc, row + dr));
        for (std::uint32_t other = grid.first[cell]; other < grid.first[cell + 1]; ++other) {
          // Where the robot walked it had room, whatever a stray point beside its way says.
          if (!grid.supports[other].trodden && isInTheWay(grid.supports[k], grid.supports[other].height, limits)) {
            clear_[other] = 0;
          }
        }
      }
    }
  }
}

Vec3 Footholds::place(std::uint32_t surface) const {
  const GridShape& shape = grid_.shape;
  const std::int32_t cell = cell_of_[surface];
  return {shape.xOf(cell % shape.width), shape.yOf(cell / shape.width), grid_.supports[surface].height};
}

std::int64_t Footholds::nearest(std::int32_t cell, double height, double reach) const {
  const auto k = static_cast<std::size_t>(cell);
  std::int64_t best = -1;
  for (std::uint32_t s = grid_.first[k]; s < grid_.first[k + 1]; ++s) {
    const double difference = std::abs(grid_.supports[s].height - height);
    if (difference <= reach) {
      best = s, reach = difference;
    }
  }
  return best;
}

double Footholds::price(std::uint32_t surface) const {
  return 1 + (kWorstFactor - 1) * grid_.supports[surface].cost / kCostWorst;
}

CostGrid withUnknownAsGround(const CostGrid& grid) {
  const GridShape& shape = grid.shape;
  const auto cells = static_cast<std::size_t>(shape.cells());
  std::vector<float> height(cells, std::numeric_limits<float>::quiet_NaN());
  std::vector<std::int32_t> queue;
  for (std::int32_t cell = 0; cell < shape.cells(); ++cell) {
    for (const Support& s : grid.column(cell)) {
      if (isWalkable(s.cost)) {
        height[static_cast<std::size_t>(cell)] = s.height;
        queue.push_back(cell);
        break;
      }
    }
  }
  for (std::size_t next = 0; next < queue.size(); ++next) {
    const std::int32_t column = queue[next] % shape.width, row = queue[next] / shape.width;
    for (const auto& [dc, dr] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const std::int32_t cell = shape.contains(column + dc, row + dr) ? shape.cell(column + dc, row + dr) : -1;
      if (cell >= 0 && grid.column(cell).empty() && std::isnan(height[static_cast<std::size_t>(cell)])) {
        height[static_cast<std::size_t>(cell)] = height[static_cast<std::size_t>(queue[next])];
        queue.push_back(cell);
      }
    }
  }
  CostGrid out{shape, {}, {}};
  for (std::size_t cell = 0; cell < cells; ++cell) {
    out.first.push_back(static_cast<std::uint32_t>(out.supports.size()));
    for (Support s : grid.column(static_cast<std::int32_t>(cell))) {
      s.cost = s.cost == kCostUnknown ? kCostWorst : s.cost;
      out.supports.push_back(s);
    }
    if (grid.column(static_cast<std::int32_t>(cell)).empty() && !std::isnan(height[cell])) {
      Support s;
      s.height = s.bottom = s.top = height[cell];
      s.cost = kCostWorst, s.seen = false;
      out.supports.push_back(s);
    }
  }
  out.first.push_back(static_cast<std::uint32_t>(out.supports.size()));
  return out;
}

}  // namespace hgg
