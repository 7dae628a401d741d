#include "eval/graph.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spd.h"
#include "map/file.h"
#include "map/position.h"
#include "region/regions.h"

namespace hgg {
namespace {

using nlohmann::json;

constexpr double kRounding = 1e-9, kLeafRounding = 1e-6;  // of a covariance's trace; leaves are stored as floats
constexpr const char* kNoLabel = " is not a whole number from 0 to 65535";

bool isLabel(const json& entry) {
  return entry.is_number_integer() && entry >= 0 && entry <= std::numeric_limits<ClassId>::max();
}

/// What is wrong with a covariance, empty when nothing is. Flat ones are fine, down to a single point.
std::string problemOf(const Mat3& cov, double rounding) {
  if (!cov.allFinite() || !std::isfinite(cov.trace())) {
    return "is not finite";
  }
  const double tolerance = rounding * std::abs(cov.trace());
  if ((cov - cov.transpose()).cwiseAbs().maxCoeff() > tolerance) {
    return "is not symmetric";
  }
  return eigenSymmetric(cov).values[0] >= -tolerance ? "" : "has a negative eigenvalue";
}

std::string problemOf(const MappedObject& object) {
  if (!object.belief.mean.allFinite()) {
    return "mean is not finite";
  }
  if (!(object.belief.kappa > 0 && std::isfinite(object.belief.kappa))) {
    return "kappa is " + json(object.belief.kappa).dump() + ", not above 0";
  }
  for (const auto& [name, cov] :
       {std::pair("cov", &object.belief.cov), std::pair("position_cov", &object.position_cov)}) {
    if (const std::string problem = problemOf(*cov, kRounding); !problem.empty()) {
      return name + (" " + problem);
    }
  }
  for (const Belief& leaf : object.geometry) {
    const std::string problem = leaf.mean.allFinite() ? problemOf(leaf.cov, kLeafRounding) : "is not finite";
    if (!problem.empty()) {
      return "geometry: a leaf's mean or cov " + problem;
    }
  }
  return "";
}

/// The graph, or what is wrong with its first unusable object: a wrong number would silently change the scores, and of
/// two objects with one id only one could be a ghost.
Result<PredictedGraph> checked(PredictedGraph graph, const std::filesystem::path& path) {
  std::set<NodeId> ids;
  for (const MappedObject& object : graph.objects) {
    const std::string problem = ids.insert(object.id).second ? problemOf(object) : "this id appears twice";
    if (!problem.empty()) {
      return Result<PredictedGraph>::fail(path.string() + ": object " + std::to_string(object.id) + ": " + problem);
    }
  }
  return Result<PredictedGraph>::ok(std::move(graph));
}

Mat3 matrixOf(const json& entry) {
  const auto rows = entry.get<std::array<double, 9>>();
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

Belief beliefOf(const json& entry) {
  const auto mean = entry.at("mean").get<std::array<double, 3>>();
  return {Vec3(mean.data()), matrixOf(entry.at("cov")), entry.at("kappa").get<double>()};
}

Result<MappedObject> predictionOf(const json& entry) {
  const json &id = entry.at("id"), &label = entry.at("label");
  if (!id.is_number_integer() || !isLabel(label)) {
    return Result<MappedObject>::fail(
        "object " + id.dump() +
        (isLabel(label) ? ": the id is not a whole number" : ": label " + label.dump() + kNoLabel));
  }
  MappedObject object;
  object.id = id.get<NodeId>();
  object.label = label.get<ClassId>();
  object.stuff = entry.value("stuff", false);
  object.dynamic = entry.value("dynamic", false);
  object.belief = beliefOf(entry);
  object.position_cov =
      entry.contains("position_cov") ? matrixOf(entry["position_cov"]) : covarianceOfIndependentPoints(object.belief);
  for (const json& leaf : entry.value("geometry", json::array())) {
    object.geometry.push_back(beliefOf(leaf));
  }
  return Result<MappedObject>::ok(std::move(object));
}

Result<std::map<ClassId, std::string>> classNamesOf(const json& classes) {
  using Names = Result<std::map<ClassId, std::string>>;
  std::map<ClassId, std::string> names;
  for (const auto& [key, name] : classes.items()) {
    ClassId id = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), id);
    if (error != std::errc() || end != key.data() + key.size()) {
      return Names::fail("class key " + json(key).dump() + kNoLabel);
    }
    names[id] = name.get<std::string>();
  }
  return Names::ok(std::move(names));
}

Result<PredictedGraph> graphOf(const json& root) {
  auto names = classNamesOf(root.value("classes", json::object()));
  if (!names) {
    return Result<PredictedGraph>::fail(names.error);
  }
  PredictedGraph graph{{}, std::move(*names)};
  for (const json& entry : root.at("objects")) {
    auto object = predictionOf(entry);
    if (!object) {
      return Result<PredictedGraph>::fail(object.error);
    }
    graph.objects.push_back(std::move(*object));
  }
  for (const json& region : root.value("regions", json::array())) {
    for (const json& id : region.at("objects")) {
      graph.region_of[id.get<NodeId>()] = region.at("id").get<std::int64_t>();
    }
  }
  return Result<PredictedGraph>::ok(std::move(graph));
}

MappedObject predictionOf(const Map& map, const MapNode& node) {
  MappedObject object{node.id, node.label, node.stuff, node.belief, positionCovarianceInMap(map, node), {}};
  object.geometry.reserve(leavesOf(node).size());
  for (const Leaf& leaf : leavesOf(node)) {
    object.geometry.push_back(transform(node.T_map_object, unpackLeaf(leaf)));
  }
  return object;
}

bool isGraphVersion1(const json& root) {
  return root.is_object() && root.value("format", "") == "hgg-graph" && root.value("version", 0) == 1;
}

}  // namespace

MappedObject transform(const Pose& T_a_b, const MappedObject& object) {
  MappedObject moved = object;
  moved.belief = transform(T_a_b, object.belief);
  moved.position_cov = T_a_b.linear() * object.position_cov * T_a_b.linear().transpose();
  for (Belief& leaf : moved.geometry) {
    leaf = transform(T_a_b, leaf);
  }
  return moved;
}

Result<PredictedGraph> readMapObjects(const std::filesystem::path& path) {
  auto stored = loadMap(path.string());
  if (!stored) {
    return Result<PredictedGraph>::fail(stored.error);
  }
  PredictedGraph graph{{}, stored->map.classNames()};
  for (const auto& [id, node] : stored->map.nodes()) {
    if (isConfirmed(node)) {
      graph.objects.push_back(predictionOf(stored->map, node));
    }
  }
  for (const Region& region : findRegions(stored->map).regions) {
    for (const NodeId id : region.objects) {
      graph.region_of[id] = region.id;
    }
  }
  graph.map = std::make_shared<const Map>(std::move(stored->map));
  return checked(std::move(graph), path);
}

Result<PredictedGraph> readGraphJson(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) {
    return Result<PredictedGraph>::fail("cannot read " + path.string());
  }
  try {
    const json root = json::parse(in);
    if (!isGraphVersion1(root)) {
      return Result<PredictedGraph>::fail(path.string() + " is not an hgg-graph of version 1");
    }
    auto graph = graphOf(root);
    return graph ? checked(std::move(*graph), path) : Result<PredictedGraph>::fail(path.string() + ": " + graph.error);
  } catch (const std::exception& e) {
    return Result<PredictedGraph>::fail(path.string() + " is not a usable graph: " + e.what());
  }
}

}  // namespace hgg
