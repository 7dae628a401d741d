#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/belief.h"
#include "core/result.h"
#include "map/node.h"

namespace hgg {

/// An object of the map under evaluation, map frame.
struct Prediction {
  NodeId id = 0;
  ClassId label = 0;
  bool stuff = false;
  Belief belief;
};

struct PredictedGraph {
  std::vector<Prediction> objects;
  std::map<ClassId, std::string> class_names;
};

/// Object nodes of a map.hgg.
Result<PredictedGraph> readMapObjects(const std::filesystem::path& path);
/// Objects of a Graph JSON, version 1.
Result<PredictedGraph> readGraphJson(const std::filesystem::path& path);

}  // namespace hgg
