#include "core/text.h"

#include <fstream>
#include <sstream>

namespace hgg {

std::optional<std::string> readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  file.peek();
  if (file.eof()) {
    return "";
  }
  std::ostringstream text;
  return file && text << file.rdbuf() ? std::optional(text.str()) : std::nullopt;
}

std::string join(const std::vector<std::string>& parts, std::string_view separator) {
  std::string out;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    out.append(i > 0 ? separator : "").append(parts[i]);
  }
  return out;
}

}  // namespace hgg
