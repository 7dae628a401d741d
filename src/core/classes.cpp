#include "core/classes.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <optional>

#include "core/text.h"
#include "default_classes.h"

namespace hgg {
namespace {

constexpr double kMinRadius = 0.02, kMaxRadius = 20;
constexpr int kUnknownMinPoints = 20;       // as of other stuff
constexpr std::size_t kMaxNameBytes = 200;  // what every message and file format carries

/// Reads one [[class]] or [[similar]] entry, collecting every complaint.
class EntryReader {
 public:
  EntryReader(const toml::table& table, std::string where, std::vector<std::string>& errors)
      : table_(table), where_(std::move(where)), errors_(errors) {}

  void complain(const std::string& what) { errors_.push_back(where_ + ": " + what); }

  template <typename T>
  std::optional<T> get(const char* key, bool required) {
    known_.emplace_back(key);
    const toml::node* node = table_.get(key);
    if (node == nullptr) {
      if (required) {
        complain(fmt::format("key '{}' is missing", key));
      }
      return std::nullopt;
    }
    // Not value(): it would take true for 1 and 20.0 for 20.
    std::optional<T> value =
        std::is_same_v<T, double> && node->is_integer() ? node->value<T>() : node->value_exact<T>();
    if (!value) {
      complain(fmt::format("'{}' has the wrong type", key));
    }
    return value;
  }

  std::vector<std::int64_t> getLabels(const char* key) {
    known_.emplace_back(key);
    std::vector<std::int64_t> labels;
    if (const toml::node* node = table_.get(key)) {
      const toml::array* array = node->as_array();
      if (array == nullptr || (!array->empty() && !array->is_homogeneous(toml::node_type::integer))) {
        complain(fmt::format("'{}' must be an array of label ids", key));
        return labels;
      }
      for (const toml::node& v : *array) {
        labels.push_back(v.value_or<std::int64_t>(-1));
      }
    }
    return labels;
  }

  void rejectUnknownKeys() {
    for (const auto& [key, value] : table_) {
      const std::string_view name = key.str();
      if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
        complain(fmt::format("unknown key '{}' (known: {})", name, join(known_, ", ")));
      }
    }
  }

 private:
  const toml::table& table_;
  std::string where_;
  std::vector<std::string>& errors_;
  std::vector<std::string> known_;
};

std::optional<ClassKind> kindOf(const std::string& word) {
  if (word == "thing") {
    return ClassKind::kThing;
  }
  if (word == "stuff") {
    return ClassKind::kStuff;
  }
  return word == "ignore" ? std::optional(ClassKind::kIgnore) : std::nullopt;
}

struct Entry {
  ClassInfo info;
  std::vector<std::int64_t> labels;  // its own id first
};

Entry readEntry(EntryReader& reader) {
  Entry entry;
  entry.labels.push_back(reader.get<std::int64_t>("id", true).value_or(0));
  entry.info.id = static_cast<ClassId>(std::clamp<std::int64_t>(entry.labels.front(), 0, 65535));
  const std::optional<std::string> name = reader.get<std::string>("name", true);
  entry.info.name = name.value_or("");
  const std::string kind = reader.get<std::string>("kind", true).value_or("ignore");
  if (const auto k = kindOf(kind)) {
    entry.info.kind = *k;
  } else {
    reader.complain(fmt::format("kind '{}' is none of thing, stuff, ignore", kind));
  }
  const bool kept = entry.info.kind != ClassKind::kIgnore;
  entry.info.dynamic = reader.get<bool>("dynamic", false).value_or(false);
  entry.info.cluster_radius = reader.get<double>("radius", entry.info.kind == ClassKind::kThing).value_or(kMinRadius);
  const std::int64_t min_points = reader.get<std::int64_t>("min_points", kept).value_or(1);
  for (const std::int64_t label : reader.getLabels("also")) {
    entry.labels.push_back(label);
  }
  reader.rejectUnknownKeys();
  if (name && (name->empty() || name->size() > kMaxNameBytes)) {
    reader.complain(fmt::format("name must have 1 .. {} bytes", kMaxNameBytes));
  }
  if (!(entry.info.cluster_radius >= kMinRadius && entry.info.cluster_radius <= kMaxRadius)) {
    reader.complain(fmt::format("radius must be {} .. {} m", kMinRadius, kMaxRadius));
  }
  if (min_points < 1 || min_points > 1'000'000) {
    reader.complain("min_points must be 1 .. 1000000");
  }
  entry.info.min_points = static_cast<int>(std::clamp<std::int64_t>(min_points, 1, 1'000'000));
  return entry;
}

SimilarClasses readSimilar(EntryReader& reader) {
  SimilarClasses similar;
  similar.a = reader.get<std::string>("a", true).value_or("");
  similar.b = reader.get<std::string>("b", true).value_or("");
  const auto similarity = reader.get<double>("similarity", true);
  reader.rejectUnknownKeys();
  similar.similarity = similarity.value_or(1);
  if (!(similar.similarity > 0 && similar.similarity <= 1)) {
    reader.complain("similarity must be above 0 and at most 1");
  }
  return similar;
}

/// All [[similar]] entries.
std::vector<SimilarClasses> readSimilarClasses(const toml::table& table, const std::string& source_name,
                                               std::vector<std::string>& errors) {
  std::vector<SimilarClasses> similar;
  const toml::node* node = table.get("similar");
  const toml::array* entries = node == nullptr ? nullptr : node->as_array();
  if (node != nullptr &&
      (entries == nullptr || (!entries->empty() && !entries->is_homogeneous(toml::node_type::table)))) {
    errors.push_back(source_name + ": 'similar' must be an array of tables");
    return similar;
  }
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    const toml::table& entry = *entries->get(i)->as_table();
    EntryReader reader(entry, fmt::format("{}:{}: [[similar]]", source_name, entry.source().begin.line), errors);
    similar.push_back(readSimilar(reader));
  }
  return similar;
}

}  // namespace

std::string ClassTable::name(ClassId label) const {
  const ClassInfo* info = find(label);
  return info != nullptr ? info->name : fmt::format("class {}", label);
}

ClassTable ClassTable::withUnknown() const {
  ClassTable table = *this;
  table.by_label_[kUnknownClass] = static_cast<std::int32_t>(table.classes_.size());
  table.classes_.push_back({kUnknownClass, "unknown", ClassKind::kStuff, false, 0, kUnknownMinPoints});
  return table;
}

Result<ClassTable> ClassTable::parse(const std::string& toml_text, const std::string& source_name) {
  const toml::parse_result parsed = toml::parse(toml_text, source_name);
  if (!parsed) {
    return Result<ClassTable>::fail(
        fmt::format("{}:{}: {}", source_name, parsed.error().source().begin.line, parsed.error().description()));
  }
  std::vector<std::string> errors;
  for (const auto& [key, value] : parsed.table()) {
    if (key.str() != "class" && key.str() != "similar") {
      errors.push_back(fmt::format("{}: unknown key '{}' (a class table holds [[class]] and [[similar]] entries only)",
                                   source_name, key.str()));
    }
  }
  const toml::array* entries = parsed.table()["class"].as_array();
  if (entries == nullptr || entries->empty()) {
    errors.push_back(source_name + ": no [[class]] entries");
  }
  ClassTable table;
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    const toml::table* entry_table = entries->get(i)->as_table();
    if (entry_table == nullptr) {
      errors.push_back(source_name + ": 'class' must be an array of tables");
      break;
    }
    EntryReader reader(*entry_table, fmt::format("{}:{}: [[class]]", source_name, entry_table->source().begin.line),
                       errors);
    const Entry entry = readEntry(reader);
    table.classes_.push_back(entry.info);
    for (const std::int64_t label : entry.labels) {
      if (label < 0 || label > 65534) {
        reader.complain(fmt::format("label {} is outside 0 .. 65534", label));
      } else if (std::int32_t& slot = table.by_label_[static_cast<std::size_t>(label)]; slot >= 0) {
        reader.complain(fmt::format("label {} already belongs to '{}'", label,
                                    table.classes_[static_cast<std::size_t>(slot)].name));
      } else {
        slot = static_cast<std::int32_t>(i);
      }
    }
  }
  table.similar_ = readSimilarClasses(parsed.table(), source_name, errors);
  if (!errors.empty()) {
    return Result<ClassTable>::fail(join(errors, "\n"));
  }
  return Result<ClassTable>::ok(std::move(table));
}

Result<ClassTable> ClassTable::load(const std::string& path) {
  const std::optional<std::string> text = readFile(path);
  if (!text) {
    return Result<ClassTable>::fail(fmt::format("{}: cannot read the class table", path));
  }
  return parse(*text, path);
}

ClassTable ClassTable::builtin() { return *parse(kDefaultClassesToml, "built-in classes.toml"); }

}  // namespace hgg
