#pragma once

#include "traversability/cost_grid.h"
#include "traversability/walked.h"

namespace hgg {

/// Makes ground of the risers of stairs, columns in which nothing but a low upright face was seen: where it ends at the
/// height of ground beside it, that ground begins in this column.
void joinRisers(CostGrid& grid, const TraversabilityConfig& limits);

/// Fills the gaps that a sparse LiDAR's rings leave on the ground: an empty column becomes a surface that was not seen
/// (confidence 0) when on two lines through it the ground goes on from one side to the other. Only within the cell of
/// surface that the leaves on either side stand for; never under or beside what stands, and never past a drop: between,
/// not beyond, what was seen. Where the robot walked one line will do, however far apart its sides.
void fillGaps(CostGrid& grid, const WalkedWay& walked, const TraversabilityConfig& limits);

}  // namespace hgg
