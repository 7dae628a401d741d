#include "core/npy.h"

#include <fmt/format.h>

#include <bit>

namespace hgg {

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

std::string npyFile(std::string_view descr, std::span<const std::size_t> shape, std::string_view data) {
  constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
  constexpr std::size_t kLengthBytes = 2;  // of the header's text
  constexpr std::size_t kAlignment = 64;   // of the data, in bytes
  std::string tuple;
  for (const std::size_t n : shape) {
    tuple += (tuple.empty() ? "" : ", ") + std::to_string(n);
  }
  tuple += shape.size() == 1 ? "," : "";
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", descr, tuple);
  text.append(kAlignment - 1 - (kMagic.size() + kLengthBytes + text.size()) % kAlignment, ' ');
  text += '\n';
  std::string file(kMagic);
  file += static_cast<char>(text.size() % 256);
  file += static_cast<char>(text.size() / 256);
  file += text;
  file += data;
  return file;
}

}  // namespace hgg
