#pragma once

#include "traversability/cost_grid.h"

namespace hgg {

/// Fills the gaps that a sparse LiDAR's rings leave on the ground: an empty column becomes a surface that was not seen
/// (confidence 0) when on two lines through it the ground goes on from one side to the other. Only within the cell of
/// surface that the leaves on either side stand for; never under or beside what stands, and never past a drop: between,
/// not beyond, what was seen.
void fillGaps(CostGrid& grid, const TraversabilityConfig& limits);

}  // namespace hgg
