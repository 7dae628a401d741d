#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// What a map says of a place.
enum class Walkability : std::uint8_t { kWalkable, kBlocked, kUnknown };

/// The grid that `hggmap export --format grid` writes beside its picture, see lcmtypes/hgg_traversability_t.lcm.
struct MapGrid {
  double origin_x = 0, origin_y = 0;  // m, map frame: the corner of cell (0, 0) with the least x and y
  double resolution = 0;              // m
  double reference_z = 0;             // m, map frame
  int width = 0, height = 0, levels = 0;
  std::vector<std::uint8_t> cost;  // (level, y, x)
  std::vector<float> heights;      // m, map frame; NaN where there is none

  std::size_t at(int level, int x, int y) const {
    return (static_cast<std::size_t>(level) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// Reads F.layers.json and the arrays it names. Errors: other formats, arrays of another size, no cost or no height.
Result<MapGrid> readMapGrid(const std::filesystem::path& layers_json);

Walkability walkabilityOf(std::uint8_t cost);
/// Heights in which a surface is looked for: the nearest to z wins.
struct HeightRange {
  double z = 0, lo = 0, hi = 0;  // m
};
/// What the grid says of a surface in a cell: the word of the level nearest in height. A blocked level without a height
/// is at every height, but only where no other is near. Outside: unknown.
Walkability walkabilityAt(const MapGrid& grid, int x, int y, const HeightRange& range);

}  // namespace hgg
