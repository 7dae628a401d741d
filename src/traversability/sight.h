#pragma once

#include <limits>
#include <span>
#include <vector>

#include "traversability/cost_grid.h"

namespace hgg {

/// The places the sensors looked from, thinned, found by where they could look at.
class Eyes {
 public:
  /// Those of the map's keyframes from which the grid may have been seen.
  Eyes(const MapLeaves& map, const GridShape& shape);

  /// Those around a cell, the nearest to its neighbourhood first, map frame.
  std::span<const Vec3> around(std::int32_t column, std::int32_t row) const;

 private:
  struct Block {
    std::uint32_t begin = 0, end = 0;  // in near_
  };

  std::vector<Vec3> all_, near_;
  std::vector<Block> blocks_;
  std::int32_t blocks_wide_ = 0, cells_per_block_ = 1;
};

/// Lines of sight over a grid, which it keeps a reference to.
class SightLines {
 public:
  SightLines(const CostGrid& grid, const MapLeaves& map);
  SightLines(CostGrid&&, const MapLeaves&) = delete;

  const CostGrid& grid() const { return grid_; }
  const Eyes& eyes() const { return eyes_; }
  /// False when something solid of the grid stands on the line from `p_map`, a place in the grid, to `p_eye`. What lies
  /// outside the grid hides nothing.
  bool isInSight(const Vec3& p_map, const Vec3& p_eye) const;
  /// True when nobody could look into the space where a body would stand on this ground: inside a car, whose sides
  /// alone were seen, or under a bus. That ground itself may have been seen well, by beams that went below the car. The
  /// same where something hangs beside, as the rim of a sign, and nobody could look at this place as high as it hangs:
  /// it may go on here.
  bool isHidden(std::int32_t column, std::int32_t row, const Support& ground, const TraversabilityConfig& limits) const;

 private:
  /// Heights of what hangs in a column lower than a body that stands on `ground` is high, m, map frame.
  void appendHanging(std::int32_t column, std::int32_t row, const Support& ground, const TraversabilityConfig& limits,
                     std::vector<double>& heights) const;
  /// Those of the nearest that hangs along each way from a column.
  std::vector<double> hangingAround(std::int32_t column, std::int32_t row, const Support& ground,
                                    const TraversabilityConfig& limits) const;

  /// The free height above the lowest solid of a column: most lines pass there, and need not look any closer.
  struct Gap {
    float low = -std::numeric_limits<float>::infinity(), high = std::numeric_limits<float>::infinity();  // m, map frame
  };

  const CostGrid& grid_;
  Eyes eyes_;
  std::vector<Gap> gaps_;  // of each cell
};

/// What is known of a surface from the places the sensors looked from: bits.
inline constexpr std::uint8_t kEdge = 1;    // it ends in view (traversability/edges.h)
inline constexpr std::uint8_t kHidden = 2;  // SightLines::isHidden; asked only of what is walkable by all else

std::uint8_t sightOn(const SightLines& sight, std::int32_t column, std::int32_t row, const Support& s,
                     const TraversabilityConfig& limits);
/// Of each surface of the grid.
std::vector<std::uint8_t> sightOn(const SightLines& sight, const TraversabilityConfig& limits,
                                  const ShareDone& progress = nullptr);

/// Blocks what lies before an edge and makes unknown what is hidden, but for where the robot walked.
void applySight(const std::vector<std::uint8_t>& sight, const WalkedWay& walked, const TraversabilityConfig& limits,
                CostGrid& grid);

}  // namespace hgg
