#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "traversability/grid_shape.h"
#include "traversability/map_leaves.h"

namespace hgg {

/// A cell of ground. A column of the grid has as many as it has storeys.
struct PlanCell {
  std::int32_t column = 0, row = 0;
  float height = 0;         // m, map frame
  float room = 0;           // m, to the nearest wall
  std::int32_t space = -1;  // index into FloorPlan::spaces; -1: a wall, or none
  bool was_seen = true;     // false: closes a gap
  bool is_wall = false;     // something that is no thing stands here, at the height of a body
  bool has_roof = false;    // a surface that was seen from below lies over it
};

/// A part of the ground that is wider than all ways out of it: a room, a corridor, a square.
struct Space {
  std::int32_t cells = 0;
  double room = 0;    // m, to the nearest wall in its middle
  double roofed = 0;  // share of it under a roof, as far as that was seen
};

/// The ground of a map with its walls, cut into spaces.
struct FloorPlan {
  GridShape shape;
  std::vector<std::uint32_t> first;  // of each cell of the grid: its first cell of ground; one more entry than cells
  std::vector<PlanCell> cells;       // by cell of the grid, then by height
  std::vector<std::array<std::int32_t, 8>> neighbors;  // of each cell, one step away; -1: none
  std::vector<Space> spaces;

  std::span<const PlanCell> at(std::int32_t column, std::int32_t row) const {
    if (!shape.contains(column, row)) {
      return {};
    }
    const auto k = static_cast<std::size_t>(shape.cell(column, row));
    return {cells.data() + first[k], cells.data() + first[k + 1]};
  }
};

/// Ground and walls out of the leaves of stuff that is seen in the map; things are furniture and no walls. Without
/// spaces.
FloorPlan buildFloorPlan(const MapLeaves& map);

/// Cuts the ground where it is narrow (Space): a watershed of the distance to the nearest wall, from the middle of
/// rooms outwards. Where two basins meet they are one if the way between them is at least kDoor times as wide as the
/// narrower of them.
void cutIntoSpaces(FloorPlan& plan);

/// True for spaces in which somebody could stand.
bool isPlace(const FloorPlan& plan, std::int32_t space);
/// True for those of them that have a roof.
bool isRoom(const FloorPlan& plan, std::int32_t space);

/// True where the straight line from one place to the other, seen from above, crosses a wall.
bool isWallBetween(const FloorPlan& plan, const Vec3& a, const Vec3& b);

}  // namespace hgg
