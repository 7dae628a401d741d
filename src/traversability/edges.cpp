#include "traversability/edges.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "traversability/point_density.h"

namespace hgg {
namespace {

/// Ground that goes on would have had this many points on a strip of columns; none at all then has a chance of e^-5.
constexpr double kExpected = 5;
/// Length of the strip behind an edge, m; longer behind leaves that stand for more.
constexpr double kStrip = 0.3;
/// A leaf may end this far behind its last points. m
constexpr double kOvershoot = 0.2;
/// Lines of sight to the ground are drawn to a place this high above it: a flat one would graze the ground itself. m
constexpr double kAbove = 0.1;

/// Ground this many times farther off than the eye is high is in view: 27 degrees below level; the lowest beams of
/// LiDARs look 15 to 25 degrees down.
constexpr double kFlatness = 2;

/// True when ground goes on in a column, or something stands there that may hide it.
bool goesOn(std::span<const Support> column, const Support& s, const TraversabilityConfig& limits) {
  return std::ranges::any_of(column, [&](const Support& other) {
    return other.top >= s.height - limits.step_height && other.bottom <= s.height + limits.body_height;
  });
}

bool endsThatWay(const SightLines& sight, std::int32_t column, std::int32_t row, std::pair<int, int> way,
                 const Support& s, const TraversabilityConfig& limits) {
  const CostGrid& grid = sight.grid();
  const GridShape& shape = grid.shape;
  const double stride = shape.resolution * std::hypot(way.first, way.second);
  const int count = static_cast<int>(std::ceil(std::max<double>(kStrip, s.reach) / stride));
  if (static_cast<double>(s.density) * count * square(shape.resolution) / kFootArea < kExpected) {
    return false;
  }
  for (int k = 1; k <= count; ++k) {
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (!shape.contains(c, r) || goesOn(grid.column(shape.cell(c, r)), s, limits)) {
      return false;
    }
  }
  const Vec3 p(shape.xOf(column), shape.yOf(row), s.height + kAbove);
  const Vec3 beyond = p + shape.resolution * count * Vec3(way.first, way.second, 0);
  return std::ranges::any_of(sight.eyes().around(column, row), [&](const Vec3& p_eye) {
    // The eye looks over the edge, and flatly: what lies before it or is near may be in the dead angle below the
    // sensor.
    const Vec3 line = p - p_eye;
    const double distance = std::hypot(line.x(), line.y()), above = p_eye.z() - s.height;
    const double along = (line.x() * way.first + line.y() * way.second) / std::hypot(way.first, way.second);
    return above > 0 && distance > kFlatness * above && along > std::cos(kPi / 8) * distance &&
           sight.isInSight(beyond, p_eye);
  });
}

}  // namespace

bool endsInView(const SightLines& sight, std::int32_t column, std::int32_t row, const Support& s,
                const TraversabilityConfig& limits) {
  return s.carries && s.seen && std::ranges::any_of(kWays, [&](const std::pair<int, int>& way) {
           return endsThatWay(sight, column, row, way, s, limits);
         });
}

void blockBeforeEdges(const std::vector<std::uint8_t>& sight, const WalkedWay& walked,
                      const TraversabilityConfig& limits, CostGrid& grid) {
  const GridShape& shape = grid.shape;
  const auto reach = static_cast<std::int32_t>(kOvershoot / shape.resolution);
  const auto block = [&](std::int32_t cell, float height) {
    for (std::uint32_t k = grid.first[static_cast<std::size_t>(cell)];
         k < grid.first[static_cast<std::size_t>(cell) + 1]; ++k) {
      Support& s = grid.supports[k];
      if (isWalkable(s.cost) && std::abs(s.height - height) <= limits.step_height &&
          !wasWalkedOn(walked, grid, cell, s)) {
        s.cost = kCostBlocked;
      }
    }
  };
  for (std::int32_t cell = 0; cell < shape.cells(); ++cell) {
    for (std::uint32_t k = grid.first[static_cast<std::size_t>(cell)];
         k < grid.first[static_cast<std::size_t>(cell) + 1]; ++k) {
      if ((sight[k] & kEdge) == 0 && !grid.supports[k].spans_hole && !grid.supports[k].hides_drop) {
        continue;
      }
      const std::int32_t column = cell % shape.width, row = cell / shape.width;
      for (std::int32_t r = row - reach; r <= row + reach; ++r) {
        for (std::int32_t c = column - reach; c <= column + reach; ++c) {
          if (shape.contains(c, r)) {
            block(shape.cell(c, r), grid.supports[k].height);
          }
        }
      }
    }
  }
}

}  // namespace hgg
