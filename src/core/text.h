#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hgg {

/// The bytes of a whole file, which may be empty; nullopt when it cannot be read (missing, a directory, no permission).
std::optional<std::string> readFile(const std::string& path);

/// The parts with `separator` between them. (fmt::join makes GCC 12 warn of an overflow that is none.)
std::string join(const std::vector<std::string>& parts, std::string_view separator);

}  // namespace hgg
