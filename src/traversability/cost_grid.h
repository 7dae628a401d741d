#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "config.h"
#include "traversability/columns.h"

namespace hgg {

/// Values of Support::cost, as lcmtypes/hgg_traversability_t.lcm has them.
inline constexpr std::uint8_t kCostFree = 0, kCostWorst = 252, kCostBlocked = 254, kCostUnknown = 255;

inline bool isWalkable(std::uint8_t cost) { return cost <= kCostWorst; }

/// Where a robot can walk: the surfaces of every column, ascending by height.
struct CostGrid {
  GridShape shape;
  std::vector<std::uint32_t> first;  // of each cell: its first surface; one more entry than there are cells
  std::vector<Support> supports;

  std::span<const Support> column(std::int32_t cell) const {
    const auto k = static_cast<std::size_t>(cell);
    return {supports.data() + first[k], supports.data() + first[k + 1]};
  }
};

/// Told how far the work is, 0..1.
using ShareDone = std::function<void(double)>;

/// The grid of a region out of the leaves of the nodes that lie in it, which must be in memory. Free needs evidence:
/// ground where no leaf is stays unknown but for narrow gaps between leaves that agree (traversability/fill.h).
CostGrid buildCostGrid(const Map& map, const GridShape& shape, const TraversabilityConfig& limits,
                       const ShareDone& progress = nullptr);

/// The region that all solid nodes lie in; nothing when there are none.
std::optional<GridRegion> regionOf(const Map& map);

/// Height of the ground that the robot walked on, m: the median of the surfaces under the keyframes, 0 when none is
/// under any.
double groundHeight(const Map& map, const CostGrid& grid);

}  // namespace hgg
