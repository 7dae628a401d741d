#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/result.h"

namespace hgg {

/// An array as NumPy's format 1.0 stores it: row-major, little-endian.
struct NpyArray {
  std::string dtype;               // "uint8", "uint16", "uint32" or "float32"
  std::vector<std::size_t> shape;  // row-major, the last index runs fastest
  std::string bytes;               // as many as shape and dtype say

  std::size_t size() const {
    std::size_t product = 1;
    for (const std::size_t n : shape) {
      product *= n;
    }
    return product;
  }
  template <typename T>
  std::vector<T> as() const {
    std::vector<T> values(size());
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
};

/// Errors: no such file, another format, Fortran order, another type, and bytes that are not those of the shape.
Result<NpyArray> readNpy(const std::filesystem::path& path);
/// Returns an error line, empty when done.
std::string writeNpy(const NpyArray& array, const std::filesystem::path& path);

template <typename T>
constexpr std::string_view npyType() {
  if constexpr (std::is_same_v<T, float>) {
    return "float32";
  } else if constexpr (std::is_same_v<T, std::uint8_t>) {
    return "uint8";
  } else if constexpr (std::is_same_v<T, std::uint16_t>) {
    return "uint16";
  } else {
    static_assert(std::is_same_v<T, std::uint32_t>);
    return "uint32";
  }
}

template <typename T>
NpyArray npyOf(const std::vector<T>& values, std::vector<std::size_t> shape) {
  NpyArray array{std::string(npyType<T>()), std::move(shape), std::string(values.size() * sizeof(T), '\0')};
  std::memcpy(array.bytes.data(), values.data(), array.bytes.size());
  return array;
}

}  // namespace hgg
