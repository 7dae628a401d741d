#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// A rectangle of the map's x and y.
struct GridRegion {
  double x_min = 0, y_min = 0, x_max = 0, y_max = 0;  // m, map frame
};

/// Where the cells of a grid lie. Cell (column, row) has its corner with the least x and y at origin + resolution *
/// (column, row). Origins are multiples of the resolution, and which cell of the map a place lies in does not depend on
/// the grid, so that grids of one map fit together.
struct GridShape {
  double x = 0, y = 0;    // m, map frame: the corner of cell (0, 0)
  double resolution = 0;  // m, edge of a cell
  std::int32_t width = 0, height = 0;
  std::int32_t first_column = 0, first_row = 0;  // of cell (0, 0) among all cells of the map: the origin / resolution

  std::int32_t cells() const { return width * height; }
  bool contains(std::int32_t column, std::int32_t row) const {
    return column >= 0 && row >= 0 && column < width && row < height;
  }
  std::int32_t cell(std::int32_t column, std::int32_t row) const { return row * width + column; }
  std::int32_t columnOf(double x_map) const {
    return static_cast<std::int32_t>(std::floor(x_map / resolution)) - first_column;
  }
  std::int32_t rowOf(double y_map) const {
    return static_cast<std::int32_t>(std::floor(y_map / resolution)) - first_row;
  }
  double xOf(std::int32_t column) const { return x + (column + 0.5) * resolution; }
  double yOf(std::int32_t row) const { return y + (row + 0.5) * resolution; }
};

/// From a cell to those around it, in cells.
inline constexpr std::array<std::pair<int, int>, 8> kWays{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

/// From a cell to the next one that way, one of eight, in cells.
inline double strideOf(std::pair<int, int> way) { return way.first != 0 && way.second != 0 ? std::numbers::sqrt2 : 1; }

/// Most cells of one grid: what a grid message may carry (lcmtypes/hgg_grid_layer_t.lcm), and bounds the memory.
inline constexpr double kMaxGridCells = 16'777'216;
inline constexpr double kMinResolution = 0.01, kMaxResolution = 10;  // m

/// Why a region is none; empty when it is one.
std::string whyNoRegion(const GridRegion& region);

/// The cells that cover `region`; an error for a region without area, a resolution out of range, or too many cells.
Result<GridShape> gridShape(const GridRegion& region, double resolution, double most_cells = kMaxGridCells);

}  // namespace hgg
