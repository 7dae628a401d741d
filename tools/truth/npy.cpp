#include "truth/npy.h"

#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <regex>
#include <sstream>

#include "core/npy.h"

namespace hgg {
namespace {

constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
constexpr std::size_t kLengthBytes = 2;  // of the header's text

struct Type {
  std::string_view dtype, descr;
  std::size_t bytes;
};
constexpr Type kTypes[] = {{"uint8", "|u1", 1}, {"uint16", "<u2", 2}, {"uint32", "<u4", 4}, {"float32", "<f4", 4}};

/// The numbers of a tuple such as "3, 4, "; nullopt where their product is no size.
std::optional<std::vector<std::size_t>> shapeOf(const std::string& tuple) {
  std::vector<std::size_t> shape;
  std::size_t product = 1;
  std::istringstream in(std::regex_replace(tuple, std::regex(","), " "));
  for (std::size_t n = 0; in >> n;) {
    if (n != 0 && product > std::numeric_limits<std::size_t>::max() / n / sizeof(double)) {
      return std::nullopt;
    }
    product *= n;
    shape.push_back(n);
  }
  return in.eof() ? std::optional(shape) : std::nullopt;
}

}  // namespace

Result<NpyArray> readNpy(const std::filesystem::path& path) {
  using Array = Result<NpyArray>;
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return Array::fail("cannot read " + path.string());
  }
  const std::string all{std::istreambuf_iterator<char>(in), {}};
  const std::size_t text_at = kMagic.size() + kLengthBytes;
  if (!all.starts_with(kMagic) || all.size() < text_at) {
    return Array::fail(path.string() + " is no array of NumPy's format 1.0");
  }
  const std::size_t length = static_cast<std::uint8_t>(all[8]) + 256U * static_cast<std::uint8_t>(all[9]);
  const std::string text = all.substr(text_at, length);
  static const std::regex kHeader(
      R"(^\{\s*'descr':\s*'([^']*)',\s*'fortran_order':\s*False,\s*'shape':\s*\(([0-9, ]*)\),?\s*\}\s*$)");
  std::smatch match;
  if (!std::regex_match(text, match, kHeader)) {
    return Array::fail(path.string() + ": its header is not that of a row-major array");
  }
  const auto shape = shapeOf(match[2]);
  for (const Type& type : kTypes) {
    if (match[1].str() == type.descr && shape) {
      NpyArray array{std::string(type.dtype), *shape, all.substr(text_at + length)};
      return array.bytes.size() == array.size() * type.bytes
                 ? Array::ok(std::move(array))
                 : Array::fail(path.string() + ": the data has not the size that the header says");
    }
  }
  return Array::fail(path.string() + ": cannot read values of type " + match[1].str());
}

std::string writeNpy(const NpyArray& array, const std::filesystem::path& path) {
  std::string_view descr;
  for (const Type& type : kTypes) {
    descr = type.dtype == array.dtype ? type.descr : descr;
  }
  std::ofstream out(path, std::ios::binary);
  out << npyFile(descr, array.shape, array.bytes);
  out.close();
  return out ? "" : "cannot write " + path.string();
}

}  // namespace hgg
