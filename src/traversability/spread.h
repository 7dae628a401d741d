#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "traversability/grid_shape.h"

namespace hgg {

/// More cells than that are not told apart by distances().
inline constexpr int kFarthestMark = std::numeric_limits<std::uint8_t>::max();

/// Of each cell, how far the nearest one with a mark is along the rows, columns and diagonals through it, in cells; 0:
/// it has one itself. Where `is_moved`, what is outside has a mark too.
std::vector<std::uint8_t> distances(const GridShape& shape, const std::vector<std::uint8_t>& marks, bool is_moved);

/// The marks (0 or 1), and one on every cell that is no more than `reach` cells from a mark along both axes.
std::vector<std::uint8_t> beside(const GridShape& shape, const std::vector<std::uint8_t>& marks, std::int32_t reach);

}  // namespace hgg
