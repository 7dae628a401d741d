#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "traversability/cost_grid.h"

namespace hgg {

/// Where the robot has walked already: no better evidence that one can. Between keyframes it went straight.
struct WalkedWay {
  std::vector<float> height;          // m, map frame, about where its feet were; one a cell, NaN where it was not
  std::vector<std::uint8_t> is_core;  // of each cell: 1 where the middle of its body was over it

  bool isOn(std::int32_t cell) const { return !std::isnan(height[static_cast<std::size_t>(cell)]); }
};

/// The columns of the grid within the footprint of the way. How high the body is above the ground is taken from the
/// ground under the keyframes; where none was seen, nothing is known of the way.
WalkedWay walkedWayOf(const MapLeaves& map, const CostGrid& grid, const TraversabilityConfig& limits);

/// True when the robot stood on this surface of the column.
bool wasWalkedOn(const WalkedWay& way, const CostGrid& grid, std::int32_t cell, const Support& s);

}  // namespace hgg
