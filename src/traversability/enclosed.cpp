#include "traversability/enclosed.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hgg {
namespace {

/// What is wider inside is no vehicle. m, from side to side
constexpr double kWidest = 3.5;
/// Ground with less than this share of the points of what stands around it was not looked at.
constexpr float kLeastShare = 0.1F;
constexpr std::size_t kLeastLines = 3;

struct Side {
  double distance = kWidest;  // m, to the first solid in the space of the body
  float density = 0;          // of that, points on a foot
};

Side look(const CostGrid& grid, std::int32_t column, std::int32_t row, std::pair<int, int> way, const Support& ground,
          const TraversabilityConfig& limits, Reach& reach) {
  const double stride = grid.shape.resolution * strideOf(way);
  const auto low = static_cast<float>(ground.height + limits.step_height);
  const auto high = static_cast<float>(ground.height + limits.body_height);
  for (int k = 1; k * stride < kWidest; ++k) {
    reach.look(k);
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (!grid.shape.contains(c, r)) {
      return {};
    }
    for (const Support& s : grid.column(grid.shape.cell(c, r))) {
      if (s.bottom < high && s.top > low) {
        return s.is_thing ? Side{k * stride, s.density} : Side{};
      }
    }
  }
  return {};
}

}  // namespace

bool isEnclosed(const CostGrid& grid, std::int32_t column, std::int32_t row, const Support& ground,
                const TraversabilityConfig& limits, Reach& reach) {
  constexpr std::array<std::pair<int, int>, 4> kLines{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  std::size_t open = 0;
  float densest = 0;
  for (const auto& [dx, dy] : kLines) {
    const Side a = look(grid, column, row, {dx, dy}, ground, limits, reach);
    const Side b = a.distance < kWidest ? look(grid, column, row, {-dx, -dy}, ground, limits, reach) : Side{};
    if (a.distance + b.distance < kWidest) {
      densest = std::max({densest, a.density, b.density});
    } else if (++open > kLines.size() - kLeastLines) {
      return false;
    }
  }
  return ground.density < kLeastShare * densest;
}

}  // namespace hgg
