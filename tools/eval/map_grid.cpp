#include "eval/map_grid.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "truth/npy.h"

namespace hgg {
namespace {

using nlohmann::json;

constexpr std::uint8_t kWorst = 252, kUnknownCost = 255;  // of hgg.traversability_t
constexpr int kMaxSide = 100'000, kMaxLevels = 8;

/// The layer's values; an error when it is not there, or not as large as the grid.
template <typename T>
Result<std::vector<T>> layerOf(const json& layers, const char* name, const MapGrid& grid,
                               const std::filesystem::path& folder) {
  using Values = Result<std::vector<T>>;
  if (!layers.contains(name)) {
    return Values::fail(std::string("there is no layer \"") + name + "\"");
  }
  const auto array = readNpy(folder / layers.at(name).at("file").get<std::string>());
  if (!array) {
    return Values::fail(array.error);
  }
  const std::vector<std::size_t> shape{static_cast<std::size_t>(grid.levels), static_cast<std::size_t>(grid.height),
                                       static_cast<std::size_t>(grid.width)};
  return array->dtype == npyType<T>() && array->shape == shape
             ? Values::ok(array->template as<T>())
             : Values::fail(std::string("layer \"") + name + "\" has not the grid's size, or another type");
}

Result<MapGrid> parse(const json& header, const std::filesystem::path& folder) {
  using Grid = Result<MapGrid>;
  if (header.value("format", "") != "hgg-grid" || header.value("version", 0) != 1) {
    return Grid::fail("it is not a grid of version 1");
  }
  MapGrid grid;
  grid.origin_x = header.at("origin").at(0), grid.origin_y = header.at("origin").at(1);
  grid.resolution = header.at("resolution"), grid.reference_z = header.at("reference_z");
  grid.width = header.at("width"), grid.height = header.at("height"), grid.levels = header.at("levels");
  const bool is_sane = grid.resolution > 0 && grid.width > 0 && grid.height > 0 && grid.levels > 0 &&
                       grid.width <= kMaxSide && grid.height <= kMaxSide && grid.levels <= kMaxLevels;
  if (!is_sane) {
    return Grid::fail("its size makes no sense");
  }
  auto cost = layerOf<std::uint8_t>(header.at("layers"), "cost", grid, folder);
  auto heights = layerOf<float>(header.at("layers"), "height", grid, folder);
  if (!cost || !heights) {
    return Grid::fail(!cost ? cost.error : heights.error);
  }
  grid.cost = std::move(*cost), grid.heights = std::move(*heights);
  return Grid::ok(std::move(grid));
}

}  // namespace

Result<MapGrid> readMapGrid(const std::filesystem::path& layers_json) {
  using Grid = Result<MapGrid>;
  std::ifstream in(layers_json);
  if (!in) {
    return Grid::fail("cannot read " + layers_json.string());
  }
  try {
    auto grid = parse(json::parse(in), layers_json.parent_path());
    return grid ? std::move(grid) : Grid::fail(layers_json.string() + ": " + grid.error);
  } catch (const json::exception& e) {
    return Grid::fail(layers_json.string() + " does not describe a grid: " + e.what());
  }
}

Walkability walkabilityOf(std::uint8_t cost) {
  return cost <= kWorst ? Walkability::kWalkable : cost == kUnknownCost ? Walkability::kUnknown : Walkability::kBlocked;
}

Walkability walkabilityAt(const MapGrid& grid, int x, int y, const HeightRange& range) {
  Walkability found = Walkability::kUnknown;
  if (x < 0 || y < 0 || x >= grid.width || y >= grid.height) {
    return found;
  }
  std::optional<double> nearest;
  for (int level = 0; level < grid.levels; ++level) {
    const Walkability verdict = walkabilityOf(grid.cost[grid.at(level, x, y)]);
    const auto height = static_cast<double>(grid.heights[grid.at(level, x, y)]);
    const double apart = std::abs(height - range.z);
    if (std::isnan(height)) {
      found = verdict == Walkability::kBlocked && !nearest ? verdict : found;
    } else if (height >= range.lo && height <= range.hi && apart <= nearest.value_or(apart) &&
               verdict != Walkability::kUnknown) {
      nearest = apart;
      found = verdict;
    }
  }
  return found;
}

}  // namespace hgg
