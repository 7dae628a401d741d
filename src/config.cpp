#include "config.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "config_keys.h"
#include "core/text.h"
#include "core/toml_text.h"

namespace hgg {
namespace {

using NamedCost = std::pair<std::string, PairCost>;
const NamedCost kPairCosts[] = {
    {"wasserstein", PairCost::kWasserstein}, {"centroid", PairCost::kCentroid}, {"iou", PairCost::kIou}};

bool isNumber(const toml::node& node) { return node.is_number(); }

std::string dotted(const char* section, const char* key) {
  return *section == '\0' ? key : fmt::format("{}.{}", section, key);
}

/// Takes values out of a parsed file, collecting every complaint.
class Reader {
 public:
  Reader(const toml::table& table, const std::string& source) : table_(table), source_(source) {}

  template <typename T>
  void operator()(const char* section, const char* key, T& member, const KeyDoc& doc) {
    const std::string name = dotted(section, key);
    known_.insert({section, key});
    if (*section != '\0') {
      sections_.insert(section);
    }
    const toml::node* node = find(section, key);
    if (node == nullptr) {
      return;
    }
    if (!take(*node, member)) {
      complain(*node, fmt::format("'{}' must be {}", name, typeName<T>()));
      return;
    }
    if constexpr (std::is_same_v<T, int> || std::is_same_v<T, double>) {
      const auto value = static_cast<double>(member);
      if (!(value >= doc.min && value <= doc.max)) {
        complain(*node, fmt::format("'{}' = {} is outside {} .. {} {}", name, value, doc.min, doc.max, doc.unit));
      }
    } else if constexpr (std::is_same_v<T, Mounting>) {
      if (!std::ranges::all_of(numbersOf(member), [&](double v) { return v >= doc.min && v <= doc.max; })) {
        complain(*node, fmt::format("'{}' has a number outside {} .. {}", name, doc.min, doc.max));
      }
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (member.empty() && name != "classes" && name != "rig.file") {
        complain(*node, fmt::format("'{}' must not be empty", name));
      }
    }
  }

  /// Complaints, unknown keys included, in the order of the lines.
  std::vector<std::string> finish() {
    rejectUnknown(table_, "");
    std::stable_sort(errors_.begin(), errors_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> lines;
    for (const auto& [line, text] : errors_) {
      lines.push_back(fmt::format("{}:{}: {}", source_, line, text));
    }
    return lines;
  }

  void complain(const toml::node& node, std::string text) {
    errors_.emplace_back(node.source().begin.line, std::move(text));
  }

 private:
  const toml::node* find(const std::string& section, const std::string& key) const {
    const toml::table* table = section.empty() ? &table_ : table_[section].as_table();
    return table == nullptr ? nullptr : table->get(key);
  }

  template <typename T>
  static const char* typeName() {
    return std::is_same_v<T, std::string> ? "a string"
           : std::is_same_v<T, bool>      ? "true or false"
           : std::is_same_v<T, int>       ? "an integer"
           : std::is_same_v<T, Mounting>  ? "[x, y, z, roll, pitch, yaw], six numbers in m and degrees"
           : std::is_same_v<T, PairCost>  ? "\"wasserstein\", \"centroid\" or \"iou\""
                                          : "a number";
  }

  template <typename T>
  static bool take(const toml::node& node, T& member) {
    if constexpr (std::is_same_v<T, int>) {
      const auto value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
      member = value ? static_cast<int>(std::clamp<std::int64_t>(*value, INT32_MIN, INT32_MAX)) : member;
      return value.has_value();
    } else if constexpr (std::is_same_v<T, Mounting>) {
      const toml::array* array = node.as_array();
      std::array<double, 6> v{};
      if (array == nullptr || array->size() != v.size() || !std::ranges::all_of(*array, isNumber)) {
        return false;
      }
      std::ranges::transform(*array, v.begin(), [](const toml::node& n) { return *n.value<double>(); });
      member = mountingOf(v);
      return true;
    } else if constexpr (std::is_same_v<T, PairCost>) {
      const auto* const name = std::ranges::find(kPairCosts, node.value_or(std::string()), &NamedCost::first);
      member = name != std::end(kPairCosts) ? name->second : member;
      return name != std::end(kPairCosts);
    } else {
      const auto value = node.is_boolean() == std::is_same_v<T, bool> ? node.value<T>() : std::nullopt;
      member = value.value_or(member);
      return value.has_value();
    }
  }

  void rejectUnknown(const toml::table& table, const std::string& section) {
    for (const auto& [key, node] : table) {
      const std::string name = dotted(section.c_str(), std::string(key.str()).c_str());
      const toml::table* inner = node.as_table();
      if (section.empty() && sections_.contains(name)) {
        inner != nullptr ? rejectUnknown(*inner, name)
                         : complain(node, fmt::format("'{}' must be a section, [{}]", name, name));
      } else if (!known_.contains({section, std::string(key.str())})) {
        complain(node, section == "T_body_lidar"
                           ? explainUnknownChannel(std::string(key.str()))
                           : fmt::format("unknown key '{}' (hggmap run --print-config shows all)", name));
      }
    }
  }

  std::string explainUnknownChannel(const std::string& channel) const {
    std::vector<std::string> channels;
    for (const auto& [section, key] : known_) {
      if (section == "T_body_lidar") {
        channels.push_back(key);
      }
    }
    return fmt::format("'T_body_lidar.{}': no cloud channel has this name (there is {})", channel,
                       join(channels, ", "));
  }

  const toml::table& table_;
  const std::string& source_;
  std::set<std::pair<std::string, std::string>> known_;  // section, key
  std::set<std::string> sections_;
  std::vector<std::pair<toml::source_index, std::string>> errors_;
};

/// Checks beyond the range of one key.
std::vector<std::string> crossCheck(const Config& c) {
  std::vector<std::string> errors;
  if (c.frame.range_min >= c.frame.range_max) {
    errors.emplace_back("'frame.range_min' must be below 'frame.range_max'");
  }
  if (c.creation.beam_factor * c.creation.beam_spacing_deg > 8) {
    errors.emplace_back("'creation.beam_factor' * 'creation.beam_spacing_deg' must be at most 8 deg");
  }
  if (c.traversability.publish_size / c.traversability.resolution > 2000) {
    errors.emplace_back("'traversability.publish_size' must be at most 2000 cells of 'traversability.resolution'");
  }
  return errors;
}

}  // namespace

Result<Config> parseConfig(const std::string& toml_text, const std::string& source_name) {
  const toml::parse_result parsed = toml::parse(toml_text, source_name);
  if (!parsed) {
    return Result<Config>::fail(
        fmt::format("{}:{}: {}", source_name, parsed.error().source().begin.line, parsed.error().description()));
  }
  Config config;
  Reader reader(parsed.table(), source_name);
  visitConfig(config, reader);
  std::vector<std::string> errors = reader.finish();
  for (const std::string& e : crossCheck(config)) {
    errors.push_back(fmt::format("{}: {}", source_name, e));
  }
  return errors.empty() ? Result<Config>::ok(config) : Result<Config>::fail(join(errors, "\n"));
}

Result<LoadedConfig> loadConfig(const std::string& path) {
  if (path.empty()) {
    return Result<LoadedConfig>::ok({Config{}, ClassTable::builtin(), ""});
  }
  const std::optional<std::string> text = readFile(path);
  if (!text) {
    return Result<LoadedConfig>::fail(fmt::format("{}: cannot read the config file", path));
  }
  Result<Config> config = parseConfig(*text, path);
  if (!config) {
    return Result<LoadedConfig>::fail(config.error);
  }
  const auto beside = [&](const std::string& file) { return std::filesystem::path(path).parent_path() / file; };
  const std::string rig_path = config->rig.file.empty() ? "" : beside(config->rig.file).string();
  if (config->classes.empty()) {
    return Result<LoadedConfig>::ok({*config, ClassTable::builtin(), rig_path});
  }
  const std::filesystem::path file = beside(config->classes);
  if (!std::filesystem::is_regular_file(file)) {
    return Result<LoadedConfig>::fail(
        fmt::format("{}: cannot read the class table (key 'classes' of {} names it)", file.string(), path));
  }
  Result<ClassTable> classes = ClassTable::load(file.string());
  return classes ? Result<LoadedConfig>::ok({*config, *classes, rig_path}) : Result<LoadedConfig>::fail(classes.error);
}

std::string printConfig(const Config& config) {
  std::string out, current;
  visitConfig(config, [&](const char* section, const char* key, const auto& member, const KeyDoc& doc) {
    using T = std::decay_t<decltype(member)>;
    if (current != section) {
      current = section;
      out += fmt::format("\n[{}]\n", section);
    }
    std::string value, about = doc.text;
    if constexpr (std::is_same_v<T, std::string>) {
      value = tomlString(member);
    } else if constexpr (std::is_same_v<T, PairCost>) {
      value = tomlString(std::ranges::find(kPairCosts, member, &NamedCost::second)->first);
    } else if constexpr (std::is_same_v<T, Mounting>) {
      for (const double v : numbersOf(member)) {
        value += (value.empty() ? "[" : ", ") + tomlFloat(v);
      }
      value += "]";
    } else if constexpr (std::is_same_v<T, double>) {
      value = tomlFloat(member);
      about += fmt::format("; {} .. {}", doc.min, doc.max);
    } else {
      value = fmt::format("{}", member);
      about += std::is_same_v<T, bool> ? "" : fmt::format("; {} .. {}", doc.min, doc.max);
    }
    out += fmt::format("{} = {}  # {}{}\n", tomlKey(key), value,
                       *doc.unit == '\0' ? "" : fmt::format("[{}] ", doc.unit), about);
  });
  return out;
}

}  // namespace hgg
