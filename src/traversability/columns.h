#pragma once

#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "traversability/grid_shape.h"
#include "traversability/map_leaves.h"
#include "traversability/sample.h"

namespace hgg {

/// Told how far the work is, 0..1.
using ShareDone = std::function<void(double)>;

/// What one leaf says of one column of a grid.
struct SheetPatch {
  std::int32_t cell = 0;
  std::int32_t sheet = 0;     // index of the leaf's sheet
  float bottom = 0, top = 0;  // m, map frame: what the leaf takes up of the column, its thickness included
  float height = 0;           // m, of the sheet
  float density = 0;          // points on the area of a foot
  float thickness = 0;        // m, standard deviation of the points about the sheet, vertically
  float reach = 0;            // m, edge of the cell of surface that the leaf stands for
  float fuzz = 0;             // m, the same along the sheet's normal, wherever that points
  bool carries = true;        // false: a wall, a pole, a ceiling
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
  float density = 0;          // points on the area of a foot, of the densest leaf of the solid
  float reach = 0;            // m, edge of the cell of surface that its leaves stand for
  float beneath = std::numeric_limits<float>::infinity();  // m, map frame: how low something was seen below it
  std::uint8_t cost = 0;                                   // hgg.traversability_t
  bool carries = true;                                     // false: a wall, a pole, a ceiling
  bool spans_hole = false;                                 // much of it lies deeper than a step below its top
  bool hides_drop = false;                                 // what was seen below it shows that ground ends here
  bool seen = true;                                        // false: filled in between what was seen
  bool trodden = false;                                    // the middle of the robot's body was over it

  bool operator==(const Support&) const = default;
};

/// True for nodes that stand in the way or carry: those that more likely exist than not.
inline bool isSolid(const MapNode& node) { return isConfirmed(node); }

/// A sheet of the map, in its frame.
struct PlacedSheet {
  LeafSheet sheet;
  std::int32_t views = 0;  // of its node
  bool carries = true;     // false: a wall, a pole, or seen from below only, as a ceiling
};

/// What the sheets of a node depend on beside its leaves.
struct NodeView {
  Pose T_map_object = Pose::Identity();
  std::vector<Vec3> eyes;  // map frame: places that tell from which side the leaves were seen
  std::int32_t views = 0;  // to a power of two: one more look at what was seen many times is no news

  bool operator==(const NodeView& other) const {
    return T_map_object.matrix() == other.T_map_object.matrix() && eyes == other.eyes && views == other.views;
  }
};
NodeView viewOf(const MapLeaves& map, const MapNode& node);
PlacedSheet placeLeaf(const Leaf& leaf, const NodeView& view);
/// Half the edges of the box around all that is drawn of a sheet, m: what stands has a depth.
Vec3 halfDrawn(const LeafSheet& sheet);
/// False where the sheet has nothing to say of the grid.
bool mayTouch(const LeafSheet& sheet, const GridShape& shape);

/// The sheets of a node's leaves that may touch the grid, in their order; appended to `sheets`.
void appendSheets(const MapLeaves& map, const MapNode& node, const GridShape& shape, std::vector<PlacedSheet>& sheets);

/// The patches of one sheet, row by row; appended to `patches` with `index` as their sheet.
void appendPatches(const PlacedSheet& placed, std::int32_t index, const GridShape& shape,
                   std::vector<SheetPatch>& patches);

/// The patches of the sheets that enough points speak for, in their order.
std::vector<SheetPatch> patchesOf(std::span<const PlacedSheet> sheets, const GridShape& shape,
                                  const ShareDone& progress = nullptr);

/// What the rest of a column says of one of its patches.
enum class Verdict : std::uint8_t {
  kHolds,
  /// Coarse leaves are a first, distant look at a place: ground that is known better by now or, where they are no thin
  /// sheet, a cloud of several surfaces. Leaves half as large with as many points within the height of the patch say
  /// what is there.
  kObsolete,
  /// A few points in front of or above a surface with many: beams went through there, so these are returns from the
  /// edge of something else, or of things that have left.
  kStray
};

/// The verdict on patch `k` of a column.
Verdict verdictOn(std::span<const SheetPatch> column, std::size_t k);

/// The surfaces of one column, ascending, out of its patches, which get sorted. Patches closer than `gap` (m) are one
/// solid; `step_height` (m) is what the robot steps over. Appended to `surfaces`, with all but slope, step and cost.
void appendSurfaces(std::span<SheetPatch> patches, double gap, double step_height, std::vector<Support>& surfaces);

}  // namespace hgg
