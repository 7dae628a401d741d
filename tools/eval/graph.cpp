#include "eval/graph.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "map/file.h"

namespace hgg {
namespace {

using nlohmann::json;

Mat3 matrixOf(const json& entry) {
  const auto rows = entry.get<std::array<double, 9>>();
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

Belief beliefOf(const json& entry) {
  const auto mean = entry.at("mean").get<std::array<double, 3>>();
  return {Vec3(mean.data()), matrixOf(entry.at("cov")), entry.at("kappa").get<double>()};
}

Prediction predictionOf(const json& entry) {
  Prediction object;
  object.id = entry.at("id").get<NodeId>();
  object.label = entry.at("label").get<ClassId>();
  object.stuff = entry.value("stuff", false);
  object.belief = beliefOf(entry);
  object.position_cov =
      entry.contains("position_cov") ? matrixOf(entry["position_cov"]) : positionCovariance(object.belief);
  for (const json& leaf : entry.value("geometry", json::array())) {
    object.geometry.push_back(beliefOf(leaf));
  }
  return object;
}

PredictedGraph graphOf(const json& root) {
  PredictedGraph graph;
  const json classes = root.value("classes", json::object());
  for (const auto& [id, name] : classes.items()) {
    graph.class_names[static_cast<ClassId>(std::stoul(id))] = name.get<std::string>();
  }
  for (const json& entry : root.at("objects")) {
    graph.objects.push_back(predictionOf(entry));
  }
  return graph;
}

Prediction predictionOf(const MapNode& node) {
  Prediction object{node.id, node.label, node.stuff, node.belief, positionCovariance(node.belief), {}};
  object.geometry.reserve(node.leaves.size());
  for (const Leaf& leaf : node.leaves) {
    object.geometry.push_back(transform(node.T_map_object, unpackLeaf(leaf)));
  }
  return object;
}

bool isGraphVersion1(const json& root) {
  return root.is_object() && root.value("format", "") == "hgg-graph" && root.value("version", 0) == 1;
}

}  // namespace

Prediction transform(const Pose& T_a_b, const Prediction& object) {
  Prediction moved = object;
  moved.belief = transform(T_a_b, object.belief);
  moved.position_cov = T_a_b.linear() * object.position_cov * T_a_b.linear().transpose();
  for (Belief& leaf : moved.geometry) {
    leaf = transform(T_a_b, leaf);
  }
  return moved;
}

Result<PredictedGraph> readMapObjects(const std::filesystem::path& path) {
  const auto stored = loadMap(path.string());
  if (!stored) {
    return Result<PredictedGraph>::fail(stored.error);
  }
  PredictedGraph graph{{}, stored->map.classNames()};
  for (const auto& [id, node] : stored->map.nodes()) {
    graph.objects.push_back(predictionOf(node));
  }
  return Result<PredictedGraph>::ok(std::move(graph));
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
    return Result<PredictedGraph>::ok(graphOf(root));
  } catch (const std::exception& e) {
    return Result<PredictedGraph>::fail(path.string() + " is not a usable graph: " + e.what());
  }
}

}  // namespace hgg
