#include "map/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spd.h"

namespace hgg {
namespace {

using Json = nlohmann::json;

/// What an object from elsewhere is taken to have been seen, when it does not say: often, and densely.
constexpr double kImportedPoints = 10'000;
constexpr std::int32_t kImportedViews = 100;
/// As creation.sigma_floor and creation.edge_geometry_share are shipped.
constexpr EdgeModel kEdgeModel{0.01, 0.5};
constexpr std::size_t kMaxNameBytes = 200;  // of a class, as in core/classes.cpp
constexpr double kFarthest = 1e6;           // m: beyond, floats of leaves lose the centimetre

/// Reads one object, keeping the first complaint.
class ObjectReader {
 public:
  explicit ObjectReader(const Json& json) : json_(json) {}

  bool has(const char* key) const { return json_.contains(key); }
  /// n finite numbers.
  std::vector<double> numbers(const char* key, std::size_t n) {
    std::vector<double> values;
    if (const auto it = json_.find(key); it != json_.end() && it->is_array() && it->size() == n) {
      for (const Json& v : *it) {
        values.push_back(v.is_number() ? v.get<double>() : NAN);
      }
    }
    const bool fine = values.size() == n && std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
    require(fine, fmt::format("'{}' must be {} numbers", key, n));
    return fine ? values : std::vector<double>(n, 0.0);
  }
  Vec3 vector(const char* key) {
    const std::vector<double> v = numbers(key, 3);
    require(std::ranges::all_of(v, [](double x) { return std::abs(x) < kFarthest; }),
            fmt::format("'{}' lies beyond 1000 km", key));
    return {v[0], v[1], v[2]};
  }
  Mat3 covariance(const char* key) {
    const std::vector<double> v = numbers(key, 9);
    Mat3 cov;
    cov << v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8];
    const bool symmetric = (cov - cov.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * (1 + cov.cwiseAbs().maxCoeff());
    Mat3 even = 0.5 * (cov + cov.transpose());
    require(symmetric && eigenSymmetric(even).values[0] > -1e-6, fmt::format("'{}' is no covariance", key));
    return even;
  }
  double number(const char* key, double otherwise, double least, double most) {
    const auto it = json_.find(key);
    if (it == json_.end()) {
      return otherwise;
    }
    const double v = it->is_number() ? it->get<double>() : NAN;
    require(v >= least && v <= most, fmt::format("'{}' must be a number in {} .. {}", key, least, most));
    return v >= least && v <= most ? v : otherwise;
  }
  std::int64_t integer(const char* key, std::int64_t otherwise) const {
    const auto it = json_.find(key);
    return it != json_.end() && it->is_number_integer() ? it->get<std::int64_t>() : otherwise;
  }
  bool flag(const char* key) const {
    const auto it = json_.find(key);
    return it != json_.end() && it->is_boolean() && it->get<bool>();
  }
  const Json& json() const { return json_; }
  void require(bool condition, const std::string& complaint) {
    error_ = error_.empty() && !condition ? complaint : error_;
  }
  const std::string& error() const { return error_; }

 private:
  const Json& json_;
  std::string error_;
};

/// Class ids by name. Names that the file gives no number are numbered from 1 on in the order of the alphabet.
class ClassNames {
 public:
  std::string add(const Json& graph) {
    if (const auto it = graph.find("classes"); it != graph.end() && it->is_object()) {
      for (const auto& [key, name] : it->items()) {
        const bool fine = !key.empty() && key.size() <= 5 && std::ranges::all_of(key, ::isdigit) &&
                          std::stoi(key) < 65535 && name.is_string() && name.get<std::string>().size() <= kMaxNameBytes;
        if (!fine) {
          return fmt::format("'classes': \"{}\" must be an id up to 65534 with a name of up to 200 bytes", key);
        }
        put(static_cast<ClassId>(std::stoi(key)), name.get<std::string>());
      }
    }
    std::set<std::string> unnumbered;
    for (const Json& object : graph["objects"]) {
      if (const auto it = object.find("label"); object.is_object() && it != object.end() && it->is_string()) {
        unnumbered.insert(it->get<std::string>().substr(0, kMaxNameBytes));
      }
    }
    ClassId next = 1;
    for (const std::string& name : unnumbered) {
      while (names_.contains(next)) {
        ++next;
      }
      if (!ids_.contains(name) && next < 65535) {
        put(next, name);
      }
    }
    return {};
  }
  /// The class of an object, by number or name.
  std::optional<ClassId> of(const Json& object) {
    const auto it = object.find("label");
    if (it != object.end() && it->is_string()) {
      const auto id = ids_.find(it->get<std::string>().substr(0, kMaxNameBytes));
      return id != ids_.end() ? std::optional(id->second) : std::nullopt;
    }
    if (it == object.end() || !it->is_number_integer() || it->get<std::int64_t>() < 0 ||
        it->get<std::int64_t>() > 65534) {
      return std::nullopt;
    }
    const auto id = it->get<ClassId>();
    if (!names_.contains(id) && object.contains("name") && object["name"].is_string()) {
      put(id, object["name"].get<std::string>().substr(0, kMaxNameBytes));
    }
    return id;
  }
  const std::map<ClassId, std::string>& names() const { return names_; }

 private:
  void put(ClassId id, const std::string& name) { names_[id] = name, ids_.try_emplace(name, id); }
  std::map<ClassId, std::string> names_;
  std::map<std::string, ClassId> ids_;
};

/// The Gaussian of a solid box: its covariance gives the box back (half an edge is sqrt(3) standard deviations).
void readBox(ObjectReader& r, MapNode& node) {
  const Vec3 size = r.vector("size");
  r.require(size.minCoeff() >= 0, "'size' is negative");
  const Mat3 R = Eigen::AngleAxisd(r.number("yaw", 0, -1e3, 1e3), Vec3::UnitZ()).toRotationMatrix();
  node.belief.mean = r.vector("center");
  node.belief.cov = R * (size.cwiseAbs2() / 12).asDiagonal() * R.transpose();
  node.T_map_object.linear() = R;
}

void readGaussian(ObjectReader& r, MapNode& node) {
  node.belief.mean = r.vector("mean");
  node.belief.cov = r.covariance("cov");
  node.T_map_object.linear() = eigenSymmetric(node.belief.cov).vectors;
}

void readLooks(ObjectReader& r, MapNode& node) {
  if (r.has("rgb")) {
    const std::vector<double> rgb = r.numbers("rgb", 3);
    r.require(std::ranges::all_of(rgb, [](double v) { return v >= 0 && v <= 255; }), "'rgb' must be within 0 .. 255");
    std::array<std::uint8_t, 3> bytes{};
    std::ranges::transform(rgb, bytes.begin(),
                           [](double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); });
    node.looks.rgb = bytes;
  }
  if (r.has("front")) {
    Vec3 towards = r.vector("front") - node.belief.mean;
    towards.z() = 0;
    if (towards.norm() > 1e-3) {  // a front above the middle points nowhere
      node.looks.front_object = node.T_map_object.linear().transpose() * towards.normalized();
    }
  }
}

void readGeometry(ObjectReader& r, MapNode& node) {
  const auto it = r.json().find("geometry");
  if (it == r.json().end()) {
    return;
  }
  r.require(it->is_array(), "'geometry' must be a list");
  Leaves leaves;
  for (const Json& leaf : it->is_array() ? *it : Json::array()) {
    ObjectReader l(leaf);
    r.require(leaf.is_object(), "a leaf must be an object");
    if (!leaf.is_object()) {
      return;
    }
    const Belief in_map{l.vector("mean"), l.covariance("cov"), l.number("kappa", 1, 0, 1e12)};
    r.require(l.error().empty(), fmt::format("a leaf: {}", l.error()));
    leaves.push_back(packLeaf(transform(node.T_map_object.inverse(), in_map)));
  }
  node.geometry = shareLeaves(std::move(leaves));
}

void readClasses(ObjectReader& r, MapNode& node) {
  if (node.stuff) {
    return;
  }
  const auto it = r.json().find("label_belief");
  const bool given = it != r.json().end() && it->is_object() && !it->empty();
  const Json shares = given ? *it : Json::object();
  for (const auto& [key, share] : shares.items()) {
    const bool fine = !key.empty() && key.size() <= 5 && std::ranges::all_of(key, ::isdigit) &&
                      std::stoi(key) < 65535 && share.is_number() && share.get<double>() >= 0 &&
                      share.get<double>() <= 1;
    r.require(fine, "'label_belief' must give classes their shares, 0 .. 1");
    if (fine) {
      addWeight(node.classes.views, static_cast<ClassId>(std::stoi(key)), share.get<double>() * node.views);
    }
  }
  if (node.classes.views.empty()) {
    addWeight(node.classes.views, node.label, node.views);
  }
}

Result<MapNode> readObject(const Json& json, ClassNames& names, std::size_t number) {
  const auto fail = [&](const std::string& why) {
    return Result<MapNode>::fail(fmt::format("object {}: {}", number, why));
  };
  if (!json.is_object()) {
    return fail("it is no JSON object");
  }
  ObjectReader r(json);
  MapNode node;
  node.id = r.integer("id", -1);
  r.require(node.id >= 0 && node.id < (std::int64_t{1} << 62), "'id' must be a number from 0 on");
  const std::optional<ClassId> label = names.of(json);
  r.require(label.has_value(), "'label' must be a class number up to 65534 or a class name");
  node.label = label.value_or(0);
  node.stuff = r.flag("stuff");
  node.views = static_cast<std::int32_t>(r.number("views", kImportedViews, 1, 1e9));
  node.first_us = r.integer("first_us", 0), node.last_us = r.integer("last_us", 0);
  if (r.has("center") && r.has("size")) {
    readBox(r, node);
  } else {
    r.require(r.has("mean") && r.has("cov"), "it needs 'center' and 'size', or 'mean' and 'cov'");
    readGaussian(r, node);
  }
  node.belief.kappa = r.number("kappa", kImportedPoints, 0, 1e15);
  node.T_map_object.translation() = node.belief.mean;
  readLooks(r, node);
  readGeometry(r, node);
  readClasses(r, node);
  return r.error().empty() ? Result<MapNode>::ok(std::move(node)) : fail(r.error());
}

/// Keyframes, each held to the one before it, as that is all that a graph says of them.
Result<KeyframeGraph> readKeyframes(const Json& graph) {
  KeyframeGraph keyframes;
  constexpr double kSigma = 0.02, kTurn = 7e-4;  // m, rad: what alignment loses between keyframes (map/file_read.cpp)
  const Json list = graph.value("keyframes", Json::array());
  for (const Json& json : list.is_array() ? list : Json::array()) {
    ObjectReader r(json);
    const std::vector<double> p = json.is_object() ? r.numbers("pose", 7) : std::vector<double>(7);
    const Eigen::Quaterniond q(p[6], p[3], p[4], p[5]);
    if (!json.is_object() || !r.error().empty() || std::abs(q.norm() - 1) > 1e-3) {
      return Result<KeyframeGraph>::fail("'keyframes': each needs a 'pose' of 7 numbers, x y z and a unit quaternion");
    }
    Pose T = Pose::Identity();
    T.translation() = Vec3(p[0], p[1], p[2]);
    T.linear() = q.normalized().toRotationMatrix();
    keyframes.add({r.integer("utime", 0), T});
    if (const KeyframeId k = keyframes.last(); k > 0) {
      const Pose T_a_b = keyframes.poses()[static_cast<std::size_t>(k - 1)].T_map_body.inverse() * T;
      keyframes.connect({k - 1, k, T_a_b, kSigma, kTurn, false});
    }
  }
  return Result<KeyframeGraph>::ok(std::move(keyframes));
}

}  // namespace

Result<Map> importJson(const std::string& text) {
  const Json graph = Json::parse(text, nullptr, false);
  if (!graph.is_object() || !graph.contains("objects") || !graph["objects"].is_array()) {
    return Result<Map>::fail("not a graph: JSON with a list of \"objects\" is needed");
  }
  ClassNames names;
  if (const std::string error = names.add(graph); !error.empty()) {
    return Result<Map>::fail(error);
  }
  Result<KeyframeGraph> keyframes = readKeyframes(graph);
  if (!keyframes) {
    return Result<Map>::fail(keyframes.error);
  }
  std::vector<MapNode> nodes;
  for (const Json& object : graph["objects"]) {
    Result<MapNode> node = readObject(object, names, nodes.size() + 1);
    if (!node) {
      return Result<Map>::fail(node.error);
    }
    const std::int64_t anchor = object.value("anchor", Json(-1)).is_number_integer() ? object.value("anchor", -1) : -1;
    node->anchor = anchor >= 0 && anchor <= keyframes->last() ? static_cast<KeyframeId>(anchor) : -1;
    nodes.push_back(std::move(*node));
  }
  std::ranges::sort(nodes, {}, &MapNode::id);
  const auto twice = std::ranges::adjacent_find(nodes, {}, &MapNode::id);
  if (twice != nodes.end()) {
    return Result<Map>::fail(fmt::format("two objects have the id {}", twice->id));
  }
  const NodeId next_id = nodes.empty() ? 1 : nodes.back().id + 1;
  Map map = Map::restore(std::move(nodes), std::move(*keyframes), names.names(), 1, next_id);
  map.setEdgeModel(kEdgeModel);
  return Result<Map>::ok(std::move(map));
}

}  // namespace hgg
