#pragma once

#include "traversability/cost_grid.h"
#include "traversability/walked.h"

namespace hgg {

/// Makes ground of the risers of stairs, columns in which nothing but a low upright face was seen: where it ends at the
/// height of ground beside it, that ground begins in this column.
void joinRisers(CostGrid& grid, const TraversabilityConfig& limits);

/// True when nothing stands or carries in the column: it is empty, or there are plates overhead.
bool isOpen(std::span<const Support> column, const TraversabilityConfig& limits);

/// Fills a gap that a sparse LiDAR's rings leave on the ground: an open column gets a surface that was not seen
/// (confidence 0), below all others, when on two lines through it the ground goes on from one side to the other. Only
/// within the cell of surface that the leaves on either side stand for; never under or beside what stands, and never
/// past a drop: between, not beyond, what was seen. Where the robot walked one line will do, however far apart its
/// sides. Nothing when the column is no such gap.
std::optional<Support> fillColumn(const CostGrid& grid, const WalkedWay& walked, std::int32_t column, std::int32_t row,
                                  const TraversabilityConfig& limits, Reach& reach);

/// The same for every column that is open.
void fillGaps(CostGrid& grid, const WalkedWay& walked, const TraversabilityConfig& limits);

}  // namespace hgg
