#pragma once

#include <cstdint>
#include <vector>

#include "traversability/cost_grid.h"

namespace hgg {

/// Where the robot's centre may be: the surfaces of a grid as the nodes of a graph, named by their index.
class Footholds {
 public:
  Footholds(const CostGrid& grid, const TraversabilityConfig& limits);

  const CostGrid& grid() const { return grid_; }
  std::int32_t cellOf(std::uint32_t surface) const { return cell_of_[surface]; }
  /// The middle of the surface.
  Vec3 place(std::uint32_t surface) const;
  /// True when it can be walked on and the footprint is clear of what cannot.
  bool isClear(std::uint32_t surface) const { return clear_[surface] != 0; }
  /// The surface of a cell nearest to `height`; no more than `reach` (m) from it; -1 when there is none.
  std::int64_t nearest(std::int32_t cell, double height, double reach) const;
  /// What a metre on it costs, in metres of good ground.
  double price(std::uint32_t surface) const;
  double stepHeight() const { return step_height_; }

 private:
  const CostGrid& grid_;
  double step_height_;
  std::vector<std::int32_t> cell_of_;
  std::vector<std::uint8_t> clear_;
};

/// The grid with ground where nothing is known: columns without a surface get one, as bad as can be walked on, at the
/// height of the nearest known ground, and so do surfaces that are known too little.
CostGrid withUnknownAsGround(const CostGrid& grid);

}  // namespace hgg
