#include "eval/graph.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "map/file.h"

namespace hgg {
namespace {

using nlohmann::json;

Prediction predictionOf(const json& entry) {
  const auto mean = entry.at("mean").get<std::array<double, 3>>();
  const auto cov = entry.at("cov").get<std::array<double, 9>>();
  Prediction object;
  object.id = entry.at("id").get<NodeId>();
  object.label = entry.at("label").get<ClassId>();
  object.stuff = entry.value("stuff", false);
  object.belief.mean = Vec3(mean.data());
  object.belief.cov = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(cov.data());
  object.belief.kappa = entry.at("kappa").get<double>();
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

bool isGraphVersion1(const json& root) {
  return root.is_object() && root.value("format", "") == "hgg-graph" && root.value("version", 0) == 1;
}

}  // namespace

Result<PredictedGraph> readMapObjects(const std::filesystem::path& path) {
  const auto stored = loadMap(path.string());
  if (!stored) {
    return Result<PredictedGraph>::fail(stored.error);
  }
  PredictedGraph graph{{}, stored->map.classNames()};
  for (const auto& [id, node] : stored->map.nodes()) {
    graph.objects.push_back({id, node.label, node.stuff, node.belief});
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
