#pragma once

#include "traversability/cost_grid.h"

namespace hgg {

/// True for ground inside something that was seen from the outside only, as under a car: on at least three of four
/// lines through it, objects stand close on both sides in the space of the body, and they have far more points than the
/// ground between them. Ground that a robot could get to was looked at as well as what stands around it. Walls do not
/// count: a corridor lies between two.
bool isEnclosed(const CostGrid& grid, std::int32_t column, std::int32_t row, const Support& ground,
                const TraversabilityConfig& limits, Reach& reach);

}  // namespace hgg
