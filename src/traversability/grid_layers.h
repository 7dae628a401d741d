#pragma once

#include <string>
#include <vector>

#include "traversability/cost_grid.h"

namespace hgg {

/// One layer of a grid: number (level * height + row) * width + column is the value of that cell.
struct FloatLayer {
  std::string name;
  std::vector<float> values;  // NaN where there is none
};

/// A grid as it is sent and stored (lcmtypes/hgg_traversability_t.lcm): level 0 of a column is its surface nearest to
/// reference_z, the others follow by distance to it.
struct GridLayers {
  GridShape shape;
  double reference_z = 0;  // m, map frame
  std::int32_t levels = 1;
  std::vector<std::uint8_t> cost;
  std::vector<FloatLayer> layers;  // height, slope, step, roughness, clearance, confidence
};

GridLayers layersOf(const CostGrid& grid, double reference_z);

/// One file of an export: what its name ends with, and its bytes.
struct GridFile {
  std::string suffix;
  std::string bytes;
};

/// A grid as map_server reads it (.yaml, .pgm), and its layers as NumPy arrays with a JSON beside them that says what
/// they are (docs/traversability.md). `stem` is what all their names begin with.
std::vector<GridFile> gridFiles(const GridLayers& grid, const std::string& stem);

}  // namespace hgg
