#pragma once

#include "traversability/cost_grid.h"

namespace hgg {

/// Fills a gap that a sparse LiDAR's rings leave on the ground: an empty column becomes a surface that was not seen
/// (confidence 0) when on two lines through it the ground goes on from one side to the other. Only within the cell of
/// surface that the leaves on either side stand for; never under or beside what stands, and never past a drop: between,
/// not beyond, what was seen.
/// Nothing when the column is no such gap.
std::optional<Support> fillColumn(const CostGrid& grid, std::int32_t column, std::int32_t row,
                                  const TraversabilityConfig& limits, Reach& reach);

/// The same for every column that is empty.
void fillGaps(CostGrid& grid, const TraversabilityConfig& limits);

}  // namespace hgg
