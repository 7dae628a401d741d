#include "map/export.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/spd.h"
#include "map/position.h"

namespace hgg {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json toJson(const Mat3& m) {
  Json j = Json::array();
  for (Eigen::Index i = 0; i < 9; ++i) {
    j.push_back(m(i / 3, i % 3));
  }
  return j;
}

std::string nameOf(const Map& map, ClassId label) {
  const auto it = map.classNames().find(label);
  return it != map.classNames().end() ? it->second : fmt::format("class {}", label);
}

Json toJson(const Map& map, const MapNode& node, const std::string& name) {
  Json j;
  j["id"] = node.id;
  j["label"] = node.label;
  j["name"] = name;
  j["mean"] = toJson(node.belief.mean);
  j["cov"] = toJson(node.belief.cov);
  j["kappa"] = node.belief.kappa;
  j["position_cov"] = toJson(positionCovarianceInMap(map, node));
  j["position_cov_local"] = toJson(positionCovariance(node));
  j["anchor"] = node.anchor;
  j["existence"] = existenceOf(node);
  j["label_belief"] = Json::object({{std::to_string(node.label), 1.0}});
  if (!node.stuff) {
    j["label_belief"] = Json::object();
    for (const auto& [label, probability] : classProbabilities(node.classes)) {
      j["label_belief"][std::to_string(label)] = probability;
    }
  }
  j["dynamic"] = false;
  j["stuff"] = node.stuff;
  j["first_us"] = node.first_us;
  j["last_us"] = node.last_us;
  j["views"] = node.views;
  j["geometry"] = Json::array();
  for (const Leaf& leaf : leavesOf(node)) {
    const Belief b = transform(node.T_map_object, unpackLeaf(leaf));
    j["geometry"].push_back({{"mean", toJson(b.mean)}, {"cov", toJson(b.cov)}, {"kappa", b.kappa}});
  }
  return j;
}

Json toJson(const Region& region) {
  return {{"id", region.id},
          {"name", region.name},
          {"mean", toJson(region.belief.mean)},
          {"cov", toJson(region.belief.cov)},
          {"kappa", region.belief.kappa},
          {"objects", region.objects}};
}

template <typename T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

std::array<std::uint8_t, 3> colourOf(ClassId label) {
  const double hue = std::fmod(label * 0.61803398875, 1.0) * 6;
  std::array<std::uint8_t, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double distance = std::abs(std::fmod(hue + 6 - 2.0 * static_cast<double>(k), 6.0) - 3);
    rgb[k] = static_cast<std::uint8_t>(60 + 180 * std::clamp(distance - 1, 0.0, 1.0));
  }
  return rgb;
}

std::string exportJson(const StoredMap& stored, const Regions& regions) {
  const Map& map = stored.map;
  Json j;
  j["format"] = "hgg-graph";
  j["version"] = 1;
  j["classes"] = Json::object();
  for (const auto& [id, name] : map.classNames()) {
    j["classes"][std::to_string(id)] = name;
  }
  j["objects"] = Json::array();
  for (const auto& [id, node] : map.nodes()) {
    if (isConfirmed(node)) {
      j["objects"].push_back(toJson(map, node, nameOf(map, node.label)));
    }
  }
  j["edges"] = Json::array();
  for (const Edge& e : stored.edges) {
    j["edges"].push_back({e.a, e.b, e.weight});
  }
  j["regions"] = Json::array();
  for (const Region& region : regions.regions) {
    j["regions"].push_back(toJson(region));
  }
  j["region_edges"] = Json::array();
  for (const Edge& e : regions.edges) {
    j["region_edges"].push_back({e.a, e.b, e.weight});
  }
  j["keyframes"] = Json::array();
  for (const TimedPose& k : map.keyframes().poses()) {
    const Eigen::Quaterniond q(k.T_map_body.linear());
    const Vec3 t = k.T_map_body.translation();
    j["keyframes"].push_back({{"utime", k.utime_us}, {"pose", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}}});
  }
  // A map from elsewhere may carry names that are no UTF-8: replaced, not thrown at.
  return j.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string exportPly(const StoredMap& stored) {
  std::size_t leaves = 0;
  for (const auto& [id, node] : stored.map.nodes()) {
    leaves += isConfirmed(node) ? leavesOf(node).size() : 0;
  }
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment hggmap: one vertex a leaf Gaussian, map frame, metres\nelement "
      "vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property float s0\nproperty float s1\nproperty float s2\nproperty float kappa\nproperty int object\nproperty "
      "ushort label\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      leaves);
  for (const auto& [id, node] : stored.map.nodes()) {
    if (!isConfirmed(node)) {
      continue;
    }
    const std::array<std::uint8_t, 3> rgb = colourOf(node.label);
    for (const Leaf& leaf : leavesOf(node)) {
      const Belief b = transform(node.T_map_object, unpackLeaf(leaf));
      const Eigen3 e = eigenSymmetric(b.cov);
      for (const Vec3& v : {b.mean, Vec3(e.vectors.col(0)), Vec3(e.values.cwiseMax(0).cwiseSqrt())}) {
        append(out, static_cast<float>(v.x())), append(out, static_cast<float>(v.y())),
            append(out, static_cast<float>(v.z()));
      }
      append(out, leaf.kappa);
      append(out, static_cast<std::int32_t>(id));
      append(out, node.label);
      out.append(reinterpret_cast<const char*>(rgb.data()), rgb.size());
    }
  }
  return out;
}

}  // namespace hgg
