#pragma once

#include <span>
#include <string>
#include <string_view>

namespace hgg {

/// A NumPy file, format 1.0: a row-major array whose values lie in `data`, little-endian. `descr` is NumPy's name for
/// their type, such as "|u1" or "<f4".
std::string npyFile(std::string_view descr, std::span<const std::size_t> shape, std::string_view data);

}  // namespace hgg
