#pragma once

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

/// How far from a column its verdict looked along the rows, columns and diagonals through it, in cells: what is kept of
/// a grid can so be told from what must be judged anew. Columns outside the grid count as looked at. A verdict looks
/// nowhere else but at columns that are no more than kBeside away.
class Reach {
 public:
  static constexpr int kBeside = 3;
  void look(int cells) { cells_ = cells > cells_ ? cells : cells_; }
  int cells() const { return cells_; }

 private:
  int cells_ = 0;
};

/// The grid of a region out of the leaves of the nodes that lie in it, which must be in memory. Free needs evidence:
/// ground where no leaf is stays unknown but for narrow gaps between leaves that agree (traversability/fill.h).
CostGrid buildCostGrid(const MapLeaves& map, const GridShape& shape, const TraversabilityConfig& limits,
                       const ShareDone& progress = nullptr);

/// A leaf that is obsolete in this many of its columns is so in all: what could be seen where it lies has been seen
/// better, and the rest of it lies where nobody looked, as under a car.
inline bool isObsoleteInAll(std::uint32_t obsolete, std::uint32_t columns) { return 2 * obsolete >= columns; }

struct WalkedWay;

/// Slope, step and cost of the surfaces of a column, out of all that is there. What was in sight comes after it
/// (traversability/sight.h).
void judge(CostGrid& grid, const WalkedWay& walked, std::int32_t column, std::int32_t row,
           const TraversabilityConfig& limits, Reach& reach);

/// The region that all solid nodes lie in; nothing when there are none.
std::optional<GridRegion> regionOf(const MapLeaves& map);

/// The region that was asked for, or the whole map where none was. An error where it is none or the map has nothing
/// there.
Result<GridRegion> regionWithin(const MapLeaves& map, const std::optional<GridRegion>& asked);

/// Height of the ground that the robot walked on, m: the median of the surfaces under the keyframes, 0 when none is
/// under any.
double groundHeight(const MapLeaves& map, const CostGrid& grid);

/// Height of the ground that a body at a place stands on, m: the highest surface below it in the nearest column that
/// has one; nothing where there is none within a metre.
std::optional<double> groundBelow(const CostGrid& grid, const Vec3& p_map_body);

}  // namespace hgg
