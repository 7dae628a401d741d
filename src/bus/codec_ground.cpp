#include <zstd.h>

#include <algorithm>
#include <hgg/traversability_t.hpp>
#include <octomap/raw_t.hpp>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

constexpr int kZstdLevel = 1;

/// A rectangle of a grid's cells.
struct Window {
  std::int32_t column = 0, row = 0, width = 0, height = 0;
};

/// Calls visit(number of the cell's value) level by level, row by row.
template <typename Visit>
void forEachValue(const GroundGrid& grid, const Window& w, std::int32_t levels, Visit visit) {
  for (std::int32_t level = 0; level < levels; ++level) {
    for (std::int32_t row = w.row; row < w.row + w.height; ++row) {
      const auto first =
          (static_cast<std::size_t>(level) * static_cast<std::size_t>(grid.height) + static_cast<std::size_t>(row)) *
              static_cast<std::size_t>(grid.width) +
          static_cast<std::size_t>(w.column);
      for (std::size_t k = first; k < first + static_cast<std::size_t>(w.width); ++k) {
        visit(k);
      }
    }
  }
}

/// Levels that have a value in the window, at least one.
std::int32_t levelsIn(const GroundGrid& grid, const Window& window) {
  const auto plane = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  std::size_t last = 0;
  forEachValue(grid, window, grid.levels, [&](std::size_t k) {
    const bool is_there = grid.cost[k] != hgg::traversability_t::COST_UNKNOWN ||
                          std::ranges::any_of(grid.layers, [&](const GroundLayer& layer) {
                            return layer.values[k] == layer.values[k];  // no NaN
                          });
    last = is_there ? std::max(last, k / plane) : last;
  });
  return static_cast<std::int32_t>(last) + 1;
}

template <typename T>
hgg::grid_layer_t layerOf(const std::string& name, const std::vector<T>& values) {
  hgg::grid_layer_t layer;
  layer.name = name;
  layer.format = sizeof(T) == 1 ? hgg::grid_layer_t::UINT8 : hgg::grid_layer_t::FLOAT32;
  layer.compression = hgg::grid_layer_t::ZSTD;
  const std::size_t size = values.size() * sizeof(T);
  layer.data.resize(ZSTD_compressBound(size));
  layer.data.resize(ZSTD_compress(layer.data.data(), layer.data.size(), values.data(), size, kZstdLevel));
  layer.nbytes = static_cast<std::int32_t>(layer.data.size());
  return layer;
}

/// To a thousandth (2^-10), so that what is below the grid's precision does not have to be packed; at more than 4096
/// less fine. Infinite values and NaN stay what they are.
float rounded(float value) {
  constexpr float kUnit = 12288;  // 1.5 * 2^13: floats from here to twice as much are multiples of 2^-10
  return (value + kUnit) - kUnit;
}
std::uint8_t rounded(std::uint8_t value) { return value; }

template <typename T>
std::vector<T> cut(const GroundGrid& grid, const std::vector<T>& values, const Window& window, std::int32_t levels) {
  std::vector<T> out;
  out.reserve(static_cast<std::size_t>(levels * window.width) * static_cast<std::size_t>(window.height));
  forEachValue(grid, window, levels, [&](std::size_t k) { out.push_back(rounded(values[k])); });
  return out;
}

std::vector<std::uint8_t> encodeWindow(const GroundGrid& grid, const Window& window) {
  hgg::traversability_t message{};
  message.utime = grid.utime_us;
  message.revision = grid.revision;
  message.origin[0] = grid.x + window.column * grid.resolution;
  message.origin[1] = grid.y + window.row * grid.resolution;
  message.resolution = grid.resolution;
  message.reference_z = grid.reference_z;
  message.width = window.width;
  message.height = window.height;
  message.num_levels = levelsIn(grid, window);
  message.layers.push_back(layerOf("cost", cut(grid, grid.cost, window, message.num_levels)));
  for (const GroundLayer& layer : grid.layers) {
    message.layers.push_back(layerOf(layer.name, cut(grid, layer.values, window, message.num_levels)));
  }
  message.num_layers = static_cast<std::int32_t>(message.layers.size());
  return encode(message);
}

/// Halves the longer side until each part is small enough.
void encodeParts(const GroundGrid& grid, const Window& w, std::size_t most_bytes,
                 std::vector<std::vector<std::uint8_t>>& out) {
  std::vector<std::uint8_t> message = encodeWindow(grid, w);
  if (message.size() <= most_bytes || (w.width <= 1 && w.height <= 1)) {
    out.push_back(std::move(message));
    return;
  }
  Window first = w, second = w;
  if (w.width >= w.height) {
    first.width = w.width / 2;
    second.column += first.width, second.width -= first.width;
  } else {
    first.height = w.height / 2;
    second.row += first.height, second.height -= first.height;
  }
  encodeParts(grid, first, most_bytes, out);
  encodeParts(grid, second, most_bytes, out);
}

}  // namespace

std::vector<std::vector<std::uint8_t>> encodeTraversability(const GroundGrid& grid, std::size_t most_bytes) {
  std::vector<std::vector<std::uint8_t>> out;
  constexpr std::int32_t kWidest = 256;  // cells; most such windows fit, so that few are packed in vain
  for (std::int32_t row = 0; row < grid.height; row += kWidest) {
    for (std::int32_t column = 0; column < grid.width; column += kWidest) {
      encodeParts(grid, {column, row, std::min(kWidest, grid.width - column), std::min(kWidest, grid.height - row)},
                  most_bytes, out);
    }
  }
  return out;
}

std::vector<std::uint8_t> encodeOctomap(const OctomapBytes& octomap) {
  octomap::raw_t message{};
  message.utime = octomap.utime_us;
  for (int k = 0; k < 4; ++k) {
    message.transform[k][k] = 1;  // the tree is in the map frame
  }
  message.data.assign(octomap.bytes.begin(), octomap.bytes.end());
  message.length = static_cast<std::int32_t>(message.data.size());
  return encode(message);
}

}  // namespace hgg
