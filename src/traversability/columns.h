#pragma once

#include <span>
#include <vector>

#include "map/map.h"
#include "traversability/grid_shape.h"

namespace hgg {

/// What one leaf says of one column of a grid.
struct Patch {
  std::int32_t cell = 0;
  float bottom = 0, top = 0;  // m, map frame: what the leaf takes up of the column, its thickness included
  float height = 0;           // m, of the sheet
  float density = 0;          // points on the area of a foot
  float thickness = 0;        // m, standard deviation of the points about the sheet
  float reach = 0;            // m, edge of the cell of surface that the leaf stands for
  bool steep = false;         // no ground: a wall, a pole
};

/// A solid part of a column with its top, which may carry a robot.
struct Support {
  float height = 0;           // m, map frame
  float bottom = 0, top = 0;  // m, map frame: of what is solid under the surface
  float slope = 0;            // rad
  float step = 0;             // m
  float roughness = 0;        // m
  float clearance = 0;        // m; infinite: nothing above
  float confidence = 0;       // 0..1
  float reach = 0;            // m, edge of the cell of surface that its leaves stand for
  std::uint8_t cost = 0;      // hgg.traversability_t
  bool steep = false;         // no ground
  bool seen = true;           // false: filled in between what was seen
};

/// True for nodes that stand in the way or carry: those that more likely exist than not.
inline bool isSolid(const MapNode& node) { return isConfirmed(node); }

/// The patches of the leaves (object frame) of one node, in the order of the leaves; appended to `patches`. `views`:
/// how often the node was seen.
void appendPatches(std::span<const Leaf> leaves, const Pose& T_map_object, std::int32_t views, const GridShape& shape,
                   std::vector<Patch>& patches);

/// The surfaces of one column, ascending, out of its patches, which get sorted. Patches closer than `gap` (m) are one
/// solid. Appended to `surfaces`, with all but slope, step and cost.
void appendSurfaces(std::span<Patch> patches, double gap, std::vector<Support>& surfaces);

}  // namespace hgg
