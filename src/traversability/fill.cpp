#include "traversability/fill.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/units.h"

namespace hgg {
namespace {

/// No leaf is so coarse that it speaks for ground farther away. m
constexpr double kFarthest = 2;

/// Heights that differ by no more are those of one surface: errors of poses and range. m
constexpr float kSameHeight = 0.05F;

struct Side {
  const Support* ground = nullptr;  // nullptr: nothing in reach, or no ground
  double distance = 0;              // m
};

/// The two directions of the four lines through a cell follow each other.
constexpr std::array<std::pair<int, int>, 8> kDirections{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

/// True for a plate overhead, as a ceiling or the top of a door: no ground was seen below it.
bool hangs(const Support& s, double step_height) { return !s.carries && s.top - s.bottom <= step_height; }

/// The ground at the first column that way in which something stands or carries.
Side look(const CostGrid& grid, std::int32_t column, std::int32_t row, std::pair<int, int> way, bool was_walked,
          double step_height, Reach& reach) {
  const double stride = grid.shape.resolution * strideOf(way);
  for (int k = 1; k * stride <= kFarthest; ++k) {
    reach.look(k);
    const std::int32_t c = column + k * way.first, r = row + k * way.second;
    if (!grid.shape.contains(c, r)) {
      return {};
    }
    const std::span<const Support> found = grid.column(grid.shape.cell(c, r));
    if (found.empty() || hangs(found.front(), step_height)) {
      continue;
    }
    const Support& s = found.front();
    const bool is_ground = s.carries && s.top - s.bottom <= step_height && (was_walked || k * stride <= s.reach);
    return {is_ground ? &s : nullptr, k * stride};
  }
  return {};
}

}  // namespace

bool isOpen(std::span<const Support> column, const TraversabilityConfig& limits) {
  return column.empty() || hangs(column.front(), limits.step_height);
}

std::optional<Support> fillColumn(const CostGrid& grid, const WalkedWay& walked, std::int32_t column, std::int32_t row,
                                  const TraversabilityConfig& limits, Reach& reach) {
  const std::int32_t cell = grid.shape.cell(column, row);
  const bool was_walked = walked.isOn(cell);
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0, roughness = 0;
  int lines = 0;
  for (std::size_t k = 0; k < kDirections.size(); k += 2) {
    const Side a = look(grid, column, row, kDirections[k], was_walked, limits.step_height, reach);
    const Side b = a.ground == nullptr
                       ? Side{}
                       : look(grid, column, row, kDirections[k + 1], was_walked, limits.step_height, reach);
    if (b.ground == nullptr) {
      continue;
    }
    const double steepest = std::tan(limits.max_slope_deg * kDegree);
    const double gap = a.distance + b.distance, rise = std::abs(a.ground->height - b.ground->height);
    const double most = was_walked ? 2 * kFarthest : std::min(a.ground->reach, b.ground->reach);
    if (gap > most || rise > std::min(steepest * gap, limits.step_height)) {
      continue;
    }
    const double height = (a.ground->height * b.distance + b.ground->height * a.distance) / gap;
    low = std::min(low, height), high = std::max(high, height), sum += height, ++lines;
    roughness = std::max<double>({roughness, a.ground->roughness, b.ground->roughness});
  }
  if (lines < (was_walked ? 1 : 2) || high - low > limits.step_height / 2) {
    return std::nullopt;
  }
  const std::span<const Support> above = grid.column(cell);
  Support s;
  s.height = s.bottom = s.top = static_cast<float>(sum / lines);
  s.roughness = static_cast<float>(roughness);
  s.clearance = above.empty() ? std::numeric_limits<float>::infinity() : above.front().bottom - s.height;
  s.seen = false;
  return s.clearance > limits.step_height ? std::optional(s) : std::nullopt;
}

void joinRisers(CostGrid& grid, const TraversabilityConfig& limits) {
  std::vector<std::pair<std::uint32_t, float>> joined;  // surface, confidence of the ground beside it
  for (std::int32_t row = 0; row < grid.shape.height; ++row) {
    for (std::int32_t column = 0; column < grid.shape.width; ++column) {
      const auto cell = static_cast<std::size_t>(grid.shape.cell(column, row));
      for (std::uint32_t k = grid.first[cell]; k < grid.first[cell + 1]; ++k) {
        const Support& s = grid.supports[k];
        if (s.carries || s.top - s.bottom > limits.step_height + kSameHeight) {
          continue;
        }
        for (const auto& [dx, dy] : kDirections) {
          if (!grid.shape.contains(column + dx, row + dy)) {
            continue;
          }
          const std::span<const Support> beside = grid.column(grid.shape.cell(column + dx, row + dy));
          const auto ground = std::ranges::find_if(
              beside, [&](const Support& g) { return g.carries && std::abs(g.height - s.height) <= kSameHeight; });
          if (ground != beside.end()) {
            joined.emplace_back(k, ground->confidence);
            break;
          }
        }
      }
    }
  }
  for (const auto& [k, confidence] : joined) {
    grid.supports[k].carries = true, grid.supports[k].confidence = confidence;
  }
}

void fillGaps(CostGrid& grid, const WalkedWay& walked, const TraversabilityConfig& limits) {
  CostGrid filled{grid.shape, {}, {}};
  filled.first.reserve(grid.first.size());
  filled.supports.reserve(grid.supports.size() * 5 / 4);
  for (std::int32_t row = 0; row < grid.shape.height; ++row) {
    for (std::int32_t column = 0; column < grid.shape.width; ++column) {
      filled.first.push_back(static_cast<std::uint32_t>(filled.supports.size()));
      const std::span<const Support> seen = grid.column(grid.shape.cell(column, row));
      if (isOpen(seen, limits)) {
        Reach reach;
        if (const std::optional<Support> s = fillColumn(grid, walked, column, row, limits, reach)) {
          filled.supports.push_back(*s);
        }
      }
      filled.supports.insert(filled.supports.end(), seen.begin(), seen.end());
    }
  }
  filled.first.push_back(static_cast<std::uint32_t>(filled.supports.size()));
  grid = std::move(filled);
}

}  // namespace hgg
