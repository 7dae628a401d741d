#pragma once

#include <cstdint>
#include <vector>

#include "traversability/sight.h"
#include "traversability/walked.h"

namespace hgg {

/// True where a surface ends for no reason but that there is no more ground. It was seen well, the sensor looked over
/// it at the columns behind, nothing stood in between, and yet no ground was seen there: had it gone on, it would have
/// been. Ground that ends behind an obstacle or where beams get sparse is no edge.
bool endsInView(const SightLines& sight, std::int32_t column, std::int32_t row, const Support& s,
                const TraversabilityConfig& limits);

/// Blocks what lies so near an edge, or a surface that spans a hole or hides a drop, that the ground may end there
/// already: the ellipse of a leaf reaches beyond the last points. `sight`: of each surface of the grid (sightOn).
void blockBeforeEdges(const std::vector<std::uint8_t>& sight, const WalkedWay& walked,
                      const TraversabilityConfig& limits, CostGrid& grid);

}  // namespace hgg
