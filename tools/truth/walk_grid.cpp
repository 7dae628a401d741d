#include "truth/walk_grid.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "truth/npy.h"
#include "truth/poses.h"

namespace hgg {
namespace {

using nlohmann::json;

constexpr const char* kName = "walk_grid";
constexpr const char* kLayers[] = {"known", "cell", "height", "standing", "island", "returns", "cause"};
constexpr int kMaxSide = 100'000;  // cells: 10 km; more is a broken file

std::string fileOf(const std::string& layer) { return std::string(kName) + "." + layer + ".npy"; }

json describe(const WalkGrid& grid) {
  json rows = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      rows.push_back(grid.T_grid_map.matrix()(row, column));
    }
  }
  json layers;
  for (const char* layer : kLayers) {
    layers[layer] = fileOf(layer);
  }
  return {
      {"format", "hgg-walk-grid"},
      {"version", 1},
      {"T_grid_map", rows},
      {"origin", {grid.origin_x, grid.origin_y}},
      {"resolution", grid.resolution},
      {"width", grid.width},
      {"height", grid.height},
      {"reach", grid.reach},
      {"limits",
       {{"step", grid.limits.step}, {"slope_deg", grid.limits.slope_deg}, {"body_height", grid.limits.body_height}}},
      {"layers", layers}};
}

Result<WalkGrid> parseHeader(const json& header) {
  using Grid = Result<WalkGrid>;
  if (header.value("format", "") != "hgg-walk-grid" || header.value("version", 0) != 1) {
    return Grid::fail("it is not a walk grid of version 1");
  }
  WalkGrid grid;
  const auto pose = poseOfRow(header.at("T_grid_map").get<std::array<double, 12>>());
  grid.origin_x = header.at("origin").at(0), grid.origin_y = header.at("origin").at(1);
  grid.resolution = header.at("resolution");
  grid.width = header.at("width"), grid.height = header.at("height");
  grid.reach = header.at("reach");
  const json& limits = header.at("limits");
  grid.limits = {limits.at("step"), limits.at("slope_deg"), limits.at("body_height")};
  const bool is_sane = pose && grid.resolution > 0 && grid.width > 0 && grid.height > 0 && grid.width <= kMaxSide &&
                       grid.height <= kMaxSide;
  grid.T_grid_map = pose.value_or(Pose::Identity());
  return is_sane ? Grid::ok(std::move(grid)) : Grid::fail("its pose or its size makes no sense");
}

/// An error line, empty when done.
template <typename T>
std::string readLayer(const std::filesystem::path& dir, const std::string& layer, std::vector<T>& values) {
  const auto array = readNpy(dir / fileOf(layer));
  if (!array) {
    return array.error;
  }
  if (array->dtype != npyType<T>() || array->shape.size() != 1) {
    return (dir / fileOf(layer)).string() + " is not a list of " + std::string(npyType<T>());
  }
  values = array->template as<T>();
  return "";
}

/// The surfaces as lists, as they are in the files.
struct Lists {
  std::vector<std::uint8_t> known;
  std::vector<std::uint32_t> cell;
  std::vector<float> height;
  std::vector<std::uint8_t> standing, island;
  std::vector<std::uint16_t> returns, cause;
};

/// Cells ascend, and everything is as long as it has to be.
bool isConsistent(const Lists& lists, std::size_t cells) {
  const std::size_t n = lists.cell.size();
  return lists.known.size() == cells && lists.height.size() == n && lists.standing.size() == n &&
         lists.island.size() == n && lists.returns.size() == n && lists.cause.size() == n &&
         std::ranges::is_sorted(lists.cell) && (n == 0 || lists.cell.back() < cells) &&
         std::ranges::all_of(lists.standing, [](std::uint8_t s) { return s <= std::uint8_t(Standing::kClose); });
}

void fill(WalkGrid& grid, Lists&& lists) {
  grid.known = std::move(lists.known);
  grid.first.assign(grid.cells() + 1, 0);
  for (const std::uint32_t cell : lists.cell) {
    ++grid.first[cell + 1];
  }
  for (std::size_t i = 1; i < grid.first.size(); ++i) {
    grid.first[i] += grid.first[i - 1];
  }
  for (std::size_t i = 0; i < lists.cell.size(); ++i) {
    grid.surfaces.push_back({lists.height[i], static_cast<Standing>(lists.standing[i]), lists.island[i] != 0,
                             lists.returns[i], lists.cause[i]});
  }
}

Lists listsOf(const WalkGrid& grid) {
  Lists lists;
  lists.known = grid.known;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    for (const WalkSurface& surface : grid.column(cell)) {
      constexpr std::uint32_t kMost = std::numeric_limits<std::uint16_t>::max();
      lists.cell.push_back(static_cast<std::uint32_t>(cell));
      lists.height.push_back(surface.height);
      lists.standing.push_back(static_cast<std::uint8_t>(surface.standing));
      lists.island.push_back(surface.island ? 1 : 0);
      lists.returns.push_back(static_cast<std::uint16_t>(std::min(surface.returns, kMost)));
      lists.cause.push_back(surface.cause);
    }
  }
  return lists;
}

}  // namespace

std::optional<std::size_t> WalkGrid::cellOf(double x, double y) const {
  const double column = std::floor((x - origin_x) / resolution), row = std::floor((y - origin_y) / resolution);
  const bool is_inside = column >= 0 && row >= 0 && column < width && row < height;
  return is_inside ? std::optional(at(static_cast<int>(column), static_cast<int>(row))) : std::nullopt;
}

Vec3 WalkGrid::middle(std::size_t cell, double z) const {
  const auto side = static_cast<std::size_t>(width);
  const std::size_t row = cell / side, column = cell % side;
  return {origin_x + (static_cast<double>(column) + 0.5) * resolution,
          origin_y + (static_cast<double>(row) + 0.5) * resolution, z};
}

std::optional<std::size_t> surfaceNear(const WalkGrid& grid, std::size_t cell, double z, double reach) {
  std::optional<std::size_t> nearest;
  for (std::size_t i = grid.first[cell]; i < grid.first[cell + 1]; ++i) {
    const double apart = std::abs(static_cast<double>(grid.surfaces[i].height) - z);
    if (apart <= reach) {
      reach = apart;
      nearest = i;
    }
  }
  return nearest;
}

std::vector<std::string> walkGridFiles() {
  std::vector<std::string> files{std::string(kName) + ".json"};
  for (const char* layer : kLayers) {
    files.push_back(fileOf(layer));
  }
  return files;
}

std::string writeWalkGrid(const WalkGrid& grid, const std::filesystem::path& dir) {
  const Lists lists = listsOf(grid);
  const auto path = dir / (std::string(kName) + ".json");
  std::ofstream out(path);
  out << describe(grid).dump(2) << "\n";
  out.close();
  std::string error = out ? "" : "cannot write " + path.string();
  const auto write = [&](const char* layer, const auto& values) {
    error = error.empty() ? writeNpy(npyOf(values, {values.size()}), dir / fileOf(layer)) : error;
  };
  write("known", lists.known), write("cell", lists.cell), write("height", lists.height);
  write("standing", lists.standing), write("island", lists.island), write("returns", lists.returns);
  write("cause", lists.cause);
  return error;
}

Result<WalkGrid> readWalkGrid(const std::filesystem::path& dir) {
  using Grid = Result<WalkGrid>;
  const auto path = dir / (std::string(kName) + ".json");
  std::ifstream in(path);
  if (!in) {
    return Grid::fail("cannot read " + path.string());
  }
  try {
    auto grid = parseHeader(json::parse(in));
    if (!grid) {
      return Grid::fail(path.string() + ": " + grid.error);
    }
    Lists lists;
    std::string error = readLayer(dir, "known", lists.known);
    error = error.empty() ? readLayer(dir, "cell", lists.cell) : error;
    error = error.empty() ? readLayer(dir, "height", lists.height) : error;
    error = error.empty() ? readLayer(dir, "standing", lists.standing) : error;
    error = error.empty() ? readLayer(dir, "island", lists.island) : error;
    error = error.empty() ? readLayer(dir, "returns", lists.returns) : error;
    error = error.empty() ? readLayer(dir, "cause", lists.cause) : error;
    if (error.empty() && !isConsistent(lists, grid->cells())) {
      error = path.string() + ": its layers do not fit each other";
    }
    if (!error.empty()) {
      return Grid::fail(error);
    }
    fill(*grid, std::move(lists));
    return grid;
  } catch (const json::exception& e) {
    return Grid::fail(path.string() + " is not a walk grid: " + e.what());
  }
}

}  // namespace hgg
