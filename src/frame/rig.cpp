#include "frame/rig.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/text.h"

namespace hgg {
namespace {

constexpr double kOrthonormal = 1e-4;             // most by which a rotation's columns may miss
constexpr double kFarthestMounting = 100;         // m from the body's origin
constexpr std::int64_t kMostPixels = 16'777'216;  // what the decoder takes (bus/codec.h)
constexpr std::int64_t kUnlabelled = 0;           // the number that says "no class" where the file names none
constexpr std::size_t kMostSensors = 16;          // of a kind

struct Range {
  double min = 0, max = 0;
};

/// Reads one table of the file, collecting every complaint.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string where, std::vector<std::string>& errors)
      : table_(table), where_(std::move(where)), errors_(errors) {}

  void complain(const std::string& what) { errors_.push_back(where_ + ": " + what); }

  const toml::node* find(const char* key) {
    known_.emplace_back(key);
    return table_.get(key);
  }

  std::string text(const char* key, const std::string& fallback) {
    const toml::node* node = find(key);
    const auto value = node == nullptr ? std::optional(fallback) : node->value_exact<std::string>();
    if (!value || (node != nullptr && value->empty())) {
      complain(fmt::format("'{}' must be a string that is not empty", key));
    }
    return value.value_or(fallback);
  }

  double number(const char* key, std::optional<double> fallback, const Range& range) {
    const toml::node* node = find(key);
    if (node == nullptr) {
      if (!fallback) {
        complain(fmt::format("key '{}' is missing", key));
      }
      return fallback.value_or(range.min);
    }
    const double value = node->is_number() ? *node->value<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(value >= range.min && value <= range.max)) {
      complain(fmt::format("'{}' must be a number from {} to {}", key, range.min, range.max));
      return range.min;
    }
    return value;
  }

  int integer(const char* key, std::optional<int> fallback, int min, int max) {
    const toml::node* node = table_.get(key);
    if (node != nullptr && !node->is_integer()) {
      find(key);
      complain(fmt::format("'{}' must be an integer from {} to {}", key, min, max));
      return min;
    }
    const auto value = number(key, fallback, {static_cast<double>(min), static_cast<double>(max)});
    return static_cast<int>(value);
  }

  Micros seconds(const char* key, double fallback, const Range& range) {
    return std::llround(1e6 * number(key, fallback, range));
  }

  /// All finite; empty where the key is missing or wrong.
  std::vector<double> numbers(const char* key) {
    std::vector<double> values;
    const toml::node* node = find(key);
    const toml::array* array = node == nullptr ? nullptr : node->as_array();
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
      const toml::node& v = *array->get(i);
      values.push_back(v.is_number() ? *v.value<double>() : std::numeric_limits<double>::quiet_NaN());
    }
    if (node != nullptr &&
        (array == nullptr || !std::ranges::all_of(values, [](double v) { return std::isfinite(v); }))) {
      complain(fmt::format("'{}' must be an array of numbers", key));
      values.clear();
    }
    return values;
  }

  /// A 3x4 or 4x4 matrix, row by row.
  Pose pose(const char* key) {
    Pose T = Pose::Identity();
    const bool is_there = table_.get(key) != nullptr;
    const std::vector<double> v = numbers(key);
    if (!is_there) {
      complain(fmt::format("key '{}' is missing: 12 numbers, three rows of [R t]", key));
      return T;
    }
    if (v.size() != 12 && v.size() != 16) {
      if (!v.empty()) {
        complain(fmt::format("'{}' has {} numbers, not 12: three rows of [R t]", key, v.size()));
      }
      return T;
    }
    if (v.size() == 16 && (v[12] != 0 || v[13] != 0 || v[14] != 0 || v[15] != 1)) {
      complain(fmt::format("the last row of '{}' is not 0 0 0 1: are its columns written one after the other?", key));
      return T;
    }
    for (Eigen::Index k = 0; k < 12; ++k) {
      T.matrix()(k / 4, k % 4) = v[static_cast<std::size_t>(k)];
    }
    const Mat3 R = T.linear();
    const double miss = (R.transpose() * R - Mat3::Identity()).cwiseAbs().maxCoeff();
    if (miss > kOrthonormal || R.determinant() < 0) {
      complain(
          fmt::format("the rotation of '{}' is none: {}", key,
                      miss > kOrthonormal
                          ? fmt::format("its columns miss being orthonormal by {:.2g} (are they rows of [R t]?)", miss)
                          : "it mirrors (determinant -1)"));
    } else {
      T.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
    }
    if (T.translation().cwiseAbs().maxCoeff() > kFarthestMounting) {
      complain(fmt::format("the translation of '{}' is beyond {} m: it is in metres", key, kFarthestMounting));
    }
    return T;
  }

  void rejectUnknownKeys() {
    for (const auto& [key, value] : table_) {
      if (std::ranges::find(known_, key.str()) == known_.end()) {
        complain(fmt::format("unknown key '{}' (known: {})", key.str(), join(known_, ", ")));
      }
    }
  }

 private:
  const toml::table& table_;
  std::string where_;
  std::vector<std::string>& errors_;
  std::vector<std::string> known_;
};

using NamedSet = std::pair<std::string, LabelSet>;

/// The numbers of the class table itself.
LabelSet setOf(const ClassTable& classes) {
  LabelSet set;
  for (std::int32_t number = 0; number < kUnknownClass; ++number) {
    set.class_of.push_back(classes.find(static_cast<ClassId>(number)) != nullptr ? number : LabelSet::kForeign);
  }
  const ClassInfo* zero = classes.find(kUnlabelled);
  if (zero == nullptr || zero->kind == ClassKind::kIgnore) {
    set.class_of[kUnlabelled] = kUnknownClass;
  }
  return set;
}

std::optional<ClassId> classNamed(const ClassTable& classes, const std::string& name) {
  const auto it = std::ranges::find(classes.classes(), name, &ClassInfo::name);
  return it == classes.classes().end() ? std::nullopt : std::optional(it->id);
}

void place(LabelSet& set, std::int64_t number, std::int32_t class_id, TableReader& reader) {
  if (number < 0 || number > 65535) {
    reader.complain(fmt::format("number {} is outside 0 .. 65535", number));
    return;
  }
  const auto slot = static_cast<std::size_t>(number);
  set.class_of.resize(std::max(set.class_of.size(), slot + 1), LabelSet::kForeign);
  set.class_of[slot] = class_id;
}

NamedSet readLabelSet(TableReader& reader, const ClassTable& classes) {
  NamedSet set;
  set.first = reader.text("name", "");
  for (const double number : reader.numbers("no_class")) {
    const bool is_whole = number >= 0 && number <= 65535 && number == std::floor(number);
    place(set.second, is_whole ? static_cast<std::int64_t>(number) : -1, kUnknownClass, reader);
  }
  const toml::node* node = reader.find("classes");
  const toml::table* table = node == nullptr ? nullptr : node->as_table();
  if (table == nullptr || table->empty()) {
    reader.complain("'classes' must be a table: number = \"class of the class table\"");
    return set;
  }
  for (const auto& [key, value] : *table) {
    const std::string number(key.str()), name = value.value_or(std::string());
    const auto class_id = classNamed(classes, name);
    if (number.empty() || number.size() > 5 ||
        !std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; })) {
      reader.complain(fmt::format("'{}' in 'classes' is no number", number));
    } else if (!class_id) {
      reader.complain(fmt::format("'{}' of number {} is no class of the class table", name, number));
    } else {
      place(set.second, std::stoll(number), *class_id, reader);
    }
  }
  return set;
}

RigLidar readLidar(TableReader& reader) {
  RigLidar lidar;
  lidar.name = reader.text("name", "lidar");
  lidar.channel = reader.text("channel", "LIDAR");
  lidar.T_body_lidar = reader.pose("T_body_lidar");
  lidar.offset_us = reader.seconds("time_offset_s", 0, {-10, 10});
  return lidar;
}

CameraModel readModel(TableReader& reader) {
  CameraModel model;
  const std::string lens = reader.text("model", "pinhole");
  if (lens != "pinhole" && lens != "fisheye") {
    reader.complain(fmt::format("model '{}' is neither \"pinhole\" nor \"fisheye\"", lens));
  }
  model.lens = lens == "fisheye" ? Lens::kFisheye : Lens::kPinhole;
  model.width = reader.integer("width", std::nullopt, 8, 16384);
  model.height = reader.integer("height", std::nullopt, 8, 16384);
  if (std::int64_t{model.width} * model.height > kMostPixels) {
    reader.complain(fmt::format("{} x {} is more than {} pixels", model.width, model.height, kMostPixels));
  }
  // A field of view between 5 and 150 degrees or so, a fisheye's up to a full turn; a centre in the image or near it.
  const double size = std::max(model.width, model.height);
  const Range focal{0.1 * size, 12 * size}, centre_x{-0.5 * model.width, 1.5 * model.width},
      centre_y{-0.5 * model.height, 1.5 * model.height};
  model.fx = reader.number("fx", std::nullopt, focal), model.fy = reader.number("fy", std::nullopt, focal);
  model.cx = reader.number("cx", std::nullopt, centre_x), model.cy = reader.number("cy", std::nullopt, centre_y);
  const std::vector<double> k = reader.numbers("distortion");
  const bool fits = k.empty() || k.size() == 4 || (k.size() == 5 && model.lens == Lens::kPinhole);
  if (!fits) {
    reader.complain(
        fmt::format("'distortion' has {} numbers: k1, k2, p1, p2 and maybe k3 of a pinhole, k1 .. k4 of a "
                    "fisheye",
                    k.size()));
    return model;
  }
  std::ranges::copy(k, model.distortion.begin());
  return model;
}

/// Whether the lens's formula holds up to the image's edges, nearly: else its numbers are not of this image.
void checkReach(const RigCamera& camera, TableReader& reader) {
  const CameraModel& m = camera.model;
  const double x = std::max(m.cx, m.width - 1 - m.cx) / m.fx, y = std::max(m.cy, m.height - 1 - m.cy) / m.fy;
  if (reachOf(m) < 0.5 * std::min(x, y)) {
    reader.complain("'distortion' folds the image back before half of the way to its edge: are these its numbers?");
  }
}

RigCamera readCamera(TableReader& reader, const std::vector<NamedSet>& sets, const ClassTable& classes) {
  RigCamera camera;
  camera.name = reader.text("name", "camera");
  camera.labels = reader.text("labels", "CAMERA_LABELS_" + camera.name);
  camera.depth = reader.find("depth") == nullptr ? "" : reader.text("depth", "");
  camera.model = readModel(reader);
  checkReach(camera, reader);
  camera.T_body_camera = reader.pose("T_body_camera");
  camera.offset_us = reader.seconds("time_offset_s", 0, {-10, 10});
  camera.margin = reader.integer("margin", camera.depth.empty() ? 2 : 0, 0, 32);
  camera.depth_stride = reader.integer("depth_stride", camera.depth_stride, 1, 32);
  camera.depth_unit = reader.number("depth_unit", camera.depth_unit, {1e-6, 1});
  camera.depth_min = reader.number("depth_min", camera.depth_min, {0, 100});
  camera.depth_max = reader.number("depth_max", camera.depth_max, {0, 1000});
  camera.depth_noise = reader.number("depth_noise", camera.depth_noise, {0, 1});
  const std::string wanted = reader.text("label_set", "class table");
  const auto set = std::ranges::find(sets, wanted, &NamedSet::first);
  if (wanted != "class table" && set == sets.end()) {
    reader.complain(fmt::format("there is no [[label_set]] with the name '{}'", wanted));
  }
  camera.label_set = set == sets.end() ? setOf(classes) : set->second;
  return camera;
}

/// Calls `read` for each [[name]] entry.
template <typename Read>
void readEach(const toml::table& file, const char* name, const std::string& source, std::vector<std::string>& errors,
              Read read) {
  const toml::node* node = file.get(name);
  const toml::array* entries = node == nullptr ? nullptr : node->as_array();
  if (node != nullptr && (entries == nullptr || entries->empty() || !entries->is_homogeneous(toml::node_type::table))) {
    errors.push_back(fmt::format("{}: '{}' must be [[{}]] entries", source, name, name));
    return;
  }
  for (std::size_t i = 0; entries != nullptr && i < entries->size(); ++i) {
    const toml::table& entry = *entries->get(i)->as_table();
    TableReader reader(entry, fmt::format("{}:{}: [[{}]]", source, entry.source().begin.line, name), errors);
    read(reader);
    reader.rejectUnknownKeys();
  }
}

/// Checks beyond one entry.
void crossCheck(const Rig& rig, const ClassTable& classes, const std::string& source,
                std::vector<std::string>& errors) {
  std::set<std::string> names, channels;
  const auto once = [&](std::set<std::string>& seen, const std::string& what, const char* kind) {
    if (!what.empty() && !seen.insert(what).second) {
      errors.push_back(fmt::format("{}: {} '{}' is there twice", source, kind, what));
    }
  };
  for (const RigLidar& lidar : rig.lidars) {
    once(names, lidar.name, "the name"), once(channels, lidar.channel, "the channel");
  }
  for (const RigCamera& camera : rig.cameras) {
    once(names, camera.name, "the name"), once(channels, camera.labels, "the channel");
    once(channels, camera.depth, "the channel");
  }
  if (cloudSources(rig).empty()) {
    errors.push_back(source +
                     ": nothing measures ranges: there is neither a [[lidar]] nor a [[camera]] with a 'depth' channel");
  }
  if (rig.lidars.size() > kMostSensors || rig.cameras.size() > kMostSensors) {
    errors.push_back(fmt::format("{}: more than {} sensors of a kind", source, kMostSensors));
  }
  if (classes.find(kUnknownClass) != nullptr) {
    errors.push_back(fmt::format("{}: the class table uses label {}, which is that of points no camera sees", source,
                                 kUnknownClass));
  }
}

}  // namespace

std::vector<CloudSource> cloudSources(const Rig& rig) {
  std::vector<CloudSource> sources;
  for (const RigLidar& lidar : rig.lidars) {
    sources.push_back({lidar.name, lidar.channel, &lidar, nullptr});
  }
  for (const RigCamera& camera : rig.cameras) {
    if (!camera.depth.empty()) {
      sources.push_back({camera.name, camera.depth, nullptr, &camera});
    }
  }
  return sources;
}

Result<Rig> parseRig(const std::string& toml_text, const std::string& source_name, const ClassTable& classes) {
  const toml::parse_result parsed = toml::parse(toml_text, source_name);
  if (!parsed) {
    return Result<Rig>::fail(
        fmt::format("{}:{}: {}", source_name, parsed.error().source().begin.line, parsed.error().description()));
  }
  const toml::table& file = parsed.table();
  std::vector<std::string> errors;
  Rig rig;
  TableReader top(file, source_name, errors);
  rig.wait_us = top.seconds("wait_s", 0.2, {0, 10});
  rig.max_age_us = top.seconds("max_age_s", 0.5, {0, 10});
  top.find("lidar"), top.find("camera"), top.find("label_set");
  top.rejectUnknownKeys();
  std::vector<NamedSet> sets;
  readEach(file, "label_set", source_name, errors,
           [&](TableReader& reader) { sets.push_back(readLabelSet(reader, classes)); });
  readEach(file, "lidar", source_name, errors, [&](TableReader& reader) { rig.lidars.push_back(readLidar(reader)); });
  readEach(file, "camera", source_name, errors,
           [&](TableReader& reader) { rig.cameras.push_back(readCamera(reader, sets, classes)); });
  crossCheck(rig, classes, source_name, errors);
  return errors.empty() ? Result<Rig>::ok(std::move(rig)) : Result<Rig>::fail(join(errors, "\n"));
}

Result<Rig> loadRig(const std::string& path, const ClassTable& classes) {
  const std::optional<std::string> text = readFile(path);
  return text ? parseRig(*text, path, classes)
              : Result<Rig>::fail(fmt::format("{}: cannot read the rig file (rig.file of the config names it)", path));
}

}  // namespace hgg
