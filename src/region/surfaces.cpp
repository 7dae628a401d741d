#include "region/surfaces.h"

#include <cmath>
#include <map>
#include <set>

#include "traversability/columns.h"
#include "traversability/point_density.h"

namespace hgg {
namespace {

constexpr double kBlock = 4;     // m
constexpr double kRoofed = 0.2;  // area of a roof to that of the ground: sensors see a part of either

/// False for clouds of points: crowns of trees, and leaves that bridge a corner or a gap. A wall of 0.3 m that was seen
/// from both sides is 0.09 m deep.
bool isFlat(const LeafSheet& sheet) {
  constexpr double kFlat = 3;        // times as wide as thick
  constexpr double kThickest = 0.1;  // m, standard deviation
  return sheet.thickness < kThickest && sheet.half_across > kFlat * sheet.thickness;
}

bool isLevel(const LeafSheet& sheet) {
  constexpr double kSlope = 0.7;  // cosine of 45 degrees
  return std::abs(sheet.normal.z()) > kSlope;
}

}  // namespace

StuffSurfaces surfacesOf(const MapLeaves& map) {
  std::vector<PlacedSheet> all;
  PointDensity density;
  for (const auto& [id, node] : map.nodes) {
    if (node.stuff && isConfirmed(node)) {
      const NodeView view = viewOf(map, node);
      for (const Leaf& leaf : leavesOf(node)) {
        all.push_back(placeLeaf(leaf, view));
        density.add(all.back().sheet);
      }
    }
  }
  StuffSurfaces surfaces;
  for (const PlacedSheet& placed : all) {
    if (isFlat(placed.sheet) && density.believes(placed.sheet)) {
      (placed.carries          ? surfaces.ground
       : isLevel(placed.sheet) ? surfaces.overhead
                               : surfaces.standing)
          .push_back(placed.sheet);
    }
  }
  return surfaces;
}

void keepUnderRoofs(StuffSurfaces& surfaces) {
  struct Areas {
    double ground = 0, overhead = 0;  // m^2
  };
  using Block = std::pair<std::int64_t, std::int64_t>;
  const auto blockOf = [](const LeafSheet& sheet) {
    return Block(std::llround(sheet.centre.x() / kBlock), std::llround(sheet.centre.y() / kBlock));
  };
  std::map<Block, Areas> blocks;
  for (const LeafSheet& sheet : surfaces.ground) {
    blocks[blockOf(sheet)].ground += areaOf(sheet, 0);
  }
  for (const LeafSheet& sheet : surfaces.overhead) {
    blocks[blockOf(sheet)].overhead += areaOf(sheet, 0);
  }
  std::set<Block> kept;
  for (const auto& [block, areas] : blocks) {
    if (areas.overhead > kRoofed * areas.ground) {
      for (int k = 0; k < 9; ++k) {
        kept.emplace(block.first + k % 3 - 1, block.second + k / 3 - 1);
      }
    }
  }
  for (std::vector<LeafSheet>* sheets : {&surfaces.ground, &surfaces.standing, &surfaces.overhead}) {
    std::erase_if(*sheets, [&](const LeafSheet& sheet) { return !kept.contains(blockOf(sheet)); });
  }
}

}  // namespace hgg
