#pragma once

#include <cstdint>
#include <vector>

#include "traversability/sight.h"

namespace hgg {

/// Of each surface of the grid: 1 where it ends for no reason but that there is no more ground. It was seen well, the
/// sensor looked over it at the columns behind, nothing stood in between, and yet no ground was seen there: had it gone
/// on, it would have been. Ground that ends behind an obstacle or where beams get sparse is no edge.
std::vector<std::uint8_t> edgesOf(const CostGrid& grid, const Eyes& eyes, const TraversabilityConfig& limits);

/// True when an edge at about the height of surface `s` is so near that the ground may end here already: the ellipse of
/// a leaf reaches beyond the last points.
bool isAtEdge(const CostGrid& grid, const std::vector<std::uint8_t>& edges, std::int32_t column, std::int32_t row,
              const Support& s, const TraversabilityConfig& limits);

}  // namespace hgg
