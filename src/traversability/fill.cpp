#include "traversability/fill.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/units.h"

namespace hgg {
namespace {

/// No leaf is so coarse that it speaks for ground farther away. m
constexpr double kFarthest = 2;

struct Side {
  const Support* ground = nullptr;  // nullptr: nothing in reach, or no ground
  double distance = 0;              // m
};

/// The two directions of the four lines through a cell follow each other.
constexpr std::array<std::pair<int, int>, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

/// The ground at the first column that is not empty that way.
Side look(const CostGrid& grid, std::int32_t column, std::int32_t row, std::pair<int, int> way, double step_height,
          Reach& reach) {
  const double stride = grid.shape.resolution * strideOf(way);
  for (int k = 1; k * stride <= kFarthest; ++k) {
    reach.look(k);
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (!grid.shape.contains(c, r)) {
      return {};
    }
    const std::span<const Support> found = grid.column(grid.shape.cell(c, r));
    if (found.empty()) {
      continue;
    }
    const Support& s = found.front();
    const bool is_ground = s.carries && s.top - s.bottom <= step_height && k * stride <= s.reach;
    return {is_ground ? &s : nullptr, k * stride};
  }
  return {};
}

}  // namespace

std::optional<Support> fillColumn(const CostGrid& grid, std::int32_t column, std::int32_t row,
                                  const TraversabilityConfig& limits, Reach& reach) {
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0, roughness = 0;
  int lines = 0;
  for (std::size_t k = 0; k < kDirections.size(); k += 2) {
    const Side a = look(grid, column, row, kDirections[k], limits.step_height, reach);
    const Side b =
        a.ground == nullptr ? Side{} : look(grid, column, row, kDirections[k + 1], limits.step_height, reach);
    if (b.ground == nullptr) {
      continue;
    }
    const double steepest = std::tan(limits.max_slope_deg * kDegree);
    const double gap = a.distance + b.distance, rise = std::abs(a.ground->height - b.ground->height);
    if (gap > std::min(a.ground->reach, b.ground->reach) || rise > std::min(steepest * gap, limits.step_height)) {
      continue;
    }
    const double height = (a.ground->height * b.distance + b.ground->height * a.distance) / gap;
    low = std::min(low, height), high = std::max(high, height), sum += height, ++lines;
    roughness = std::max<double>({roughness, a.ground->roughness, b.ground->roughness});
  }
  if (lines < 2 || high - low > limits.step_height / 2) {
    return std::nullopt;
  }
  Support s;
  s.height = s.bottom = s.top = static_cast<float>(sum / lines);
  s.roughness = static_cast<float>(roughness);
  s.clearance = std::numeric_limits<float>::infinity();
  s.seen = false;
  return s;
}

void fillGaps(CostGrid& grid, const TraversabilityConfig& limits) {
  CostGrid filled{grid.shape, {}, {}};
  filled.first.reserve(grid.first.size());
  filled.supports.reserve(grid.supports.size() * 5 / 4);
  for (std::int32_t row = 0; row < grid.shape.height; ++row) {
    for (std::int32_t column = 0; column < grid.shape.width; ++column) {
      filled.first.push_back(static_cast<std::uint32_t>(filled.supports.size()));
      const std::span<const Support> seen = grid.column(grid.shape.cell(column, row));
      filled.supports.insert(filled.supports.end(), seen.begin(), seen.end());
      if (seen.empty()) {
        Reach reach;
        if (const std::optional<Support> s = fillColumn(grid, column, row, limits, reach)) {
          filled.supports.push_back(*s);
        }
      }
    }
  }
  filled.first.push_back(static_cast<std::uint32_t>(filled.supports.size()));
  grid = std::move(filled);
}

}  // namespace hgg
