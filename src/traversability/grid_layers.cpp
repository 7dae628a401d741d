#include "traversability/grid_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/npy.h"

namespace hgg {
namespace {

constexpr std::int32_t kMaxLevels = 8;  // lcmtypes/hgg_traversability_t.lcm

// The grey levels of map_server.
constexpr char kGreyFree = static_cast<char>(254), kGreyOccupied = 0, kGreyUnknown = static_cast<char>(205);

struct LayerKind {
  const char* name;
  float Support::*member;
};
constexpr LayerKind kLayers[] = {{"height", &Support::height},       {"slope", &Support::slope},
                                 {"step", &Support::step},           {"roughness", &Support::roughness},
                                 {"clearance", &Support::clearance}, {"confidence", &Support::confidence}};

/// The values of a layer as a NumPy array of shape (levels, height, width).
template <typename T>
std::string npyOf(const GridLayers& grid, const std::vector<T>& values) {
  const std::array<std::size_t, 3> shape{static_cast<std::size_t>(grid.levels),
                                         static_cast<std::size_t>(grid.shape.height),
                                         static_cast<std::size_t>(grid.shape.width)};
  return npyFile(sizeof(T) == 1 ? "|u1" : "<f4", shape,
                 {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

char greyOf(std::uint8_t cost) {
  return cost == kCostUnknown ? kGreyUnknown : cost == kCostBlocked ? kGreyOccupied : kGreyFree;
}

std::string pgm(const GridLayers& grid) {
  std::string out = fmt::format("P5\n{} {}\n255\n", grid.shape.width, grid.shape.height);
  for (std::int32_t row = grid.shape.height - 1; row >= 0; --row) {
    for (std::int32_t column = 0; column < grid.shape.width; ++column) {
      out += greyOf(grid.cost[static_cast<std::size_t>(grid.shape.cell(column, row))]);
    }
  }
  return out;
}

std::string json(const GridLayers& grid, const std::string& stem) {
  nlohmann::ordered_json j;
  j["format"] = "hgg-grid", j["version"] = 1;
  j["origin"] = {grid.shape.x, grid.shape.y};
  j["resolution"] = grid.shape.resolution;
  j["width"] = grid.shape.width, j["height"] = grid.shape.height;
  j["levels"] = grid.levels;
  j["reference_z"] = grid.reference_z;
  j["layers"]["cost"] = {{"dtype", "uint8"}, {"file", stem + ".cost.npy"}};
  for (const FloatLayer& layer : grid.layers) {
    j["layers"][layer.name] = {{"dtype", "float32"}, {"file", stem + "." + layer.name + ".npy"}};
  }
  return j.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

GridLayers layersOf(const CostGrid& grid, double reference_z) {
  GridLayers out{grid.shape, reference_z, 1, {}, {}};
  const std::int32_t cells = grid.shape.cells();
  for (std::int32_t cell = 0; cell < cells; ++cell) {
    out.levels = std::max(out.levels, static_cast<std::int32_t>(grid.column(cell).size()));
  }
  // As many values as a message may carry bound the levels too.
  out.levels = std::min({out.levels, kMaxLevels, std::max(1, static_cast<std::int32_t>(kMaxGridCells) / cells)});
  const std::size_t values = static_cast<std::size_t>(out.levels) * static_cast<std::size_t>(cells);
  out.cost.assign(values, kCostUnknown);
  for (const LayerKind& kind : kLayers) {
    out.layers.push_back({kind.name, std::vector<float>(values, std::numeric_limits<float>::quiet_NaN())});
  }
  std::vector<Support> column;
  for (std::int32_t cell = 0; cell < cells; ++cell) {
    const std::span<const Support> surfaces = grid.column(cell);
    column.assign(surfaces.begin(), surfaces.end());
    std::ranges::stable_sort(column, {}, [&](const Support& s) { return std::abs(s.height - reference_z); });
    for (std::size_t k = 0; k < column.size() && k < static_cast<std::size_t>(out.levels); ++k) {
      const std::size_t value = k * static_cast<std::size_t>(cells) + static_cast<std::size_t>(cell);
      out.cost[value] = column[k].cost;
      for (std::size_t layer = 0; layer < out.layers.size(); ++layer) {
        out.layers[layer].values[value] = column[k].*kLayers[layer].member;
      }
    }
  }
  return out;
}

std::vector<GridFile> gridFiles(const GridLayers& grid, const std::string& stem) {
  std::vector<GridFile> files;
  files.push_back({".yaml", fmt::format("image: \"{}.pgm\"\nresolution: {}\norigin: [{}, {}, 0.0]\nnegate: 0\n"
                                        "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
                                        stem, grid.shape.resolution, grid.shape.x, grid.shape.y)});
  files.push_back({".pgm", pgm(grid)});
  files.push_back({".layers.json", json(grid, stem)});
  files.push_back({".cost.npy", npyOf(grid, grid.cost)});
  for (const FloatLayer& layer : grid.layers) {
    files.push_back({"." + layer.name + ".npy", npyOf(grid, layer.values)});
  }
  return files;
}

}  // namespace hgg
