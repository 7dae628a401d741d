#include "traversability/obsolete.h"

#include <algorithm>
#include <map>
#include <utility>

#include "traversability/cost_grid.h"

namespace hgg {
namespace {

constexpr std::int32_t kTile = 256;  // columns: what is worked on at a time

using TileIndex = std::pair<std::int32_t, std::int32_t>;

GridShape shapeOf(const TileIndex& tile, double cell) {
  GridShape shape;
  shape.resolution = cell;
  shape.width = shape.height = kTile;
  shape.first_column = tile.first * kTile, shape.first_row = tile.second * kTile;
  shape.x = shape.first_column * cell, shape.y = shape.first_row * cell;
  return shape;
}

/// The sheets that touch each tile, in their order.
std::map<TileIndex, std::vector<std::int32_t>> byTile(std::span<const PlacedSheet> sheets, double cell) {
  const auto tileOf = [&](double v) { return static_cast<std::int32_t>(std::floor(v / (cell * kTile))); };
  std::map<TileIndex, std::vector<std::int32_t>> tiles;
  for (std::size_t k = 0; k < sheets.size(); ++k) {
    const LeafSheet& sheet = sheets[k].sheet;
    const Vec3 half = halfBox(sheet), low = sheet.centre - half, high = sheet.centre + half;
    for (std::int32_t x = tileOf(low.x()); x <= tileOf(high.x()); ++x) {
      for (std::int32_t y = tileOf(low.y()); y <= tileOf(high.y()); ++y) {
        tiles[{x, y}].push_back(static_cast<std::int32_t>(k));
      }
    }
  }
  return tiles;
}

}  // namespace

std::vector<bool> obsoleteSheets(std::span<const PlacedSheet> sheets, double cell) {
  std::vector<std::uint32_t> columns(sheets.size(), 0), obsolete(sheets.size(), 0);
  std::vector<SheetPatch> patches;
  for (const auto& [tile, members] : byTile(sheets, cell)) {
    const GridShape shape = shapeOf(tile, cell);
    patches.clear();
    for (const std::int32_t k : members) {
      appendPatches(sheets[static_cast<std::size_t>(k)], k, shape, patches);
    }
    std::ranges::stable_sort(patches, {}, &SheetPatch::cell);
    for (std::size_t begin = 0, end = 0; begin < patches.size(); begin = end) {
      while (end < patches.size() && patches[end].cell == patches[begin].cell) {
        ++end;
      }
      const std::span<const SheetPatch> column(patches.data() + begin, end - begin);
      for (std::size_t k = 0; k < column.size(); ++k) {
        const auto sheet = static_cast<std::size_t>(column[k].sheet);
        columns[sheet] += 1, obsolete[sheet] += verdictOn(column, k) == Verdict::kObsolete ? 1 : 0;
      }
    }
  }
  std::vector<bool> out(sheets.size());
  for (std::size_t k = 0; k < sheets.size(); ++k) {
    out[k] = columns[k] > 0 && isObsoleteInAll(obsolete[k], columns[k]);
  }
  return out;
}

}  // namespace hgg
