#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/belief.h"
#include "core/result.h"
#include "map/map.h"

namespace hgg {

/// An object of the map under evaluation, map frame.
struct MappedObject {
  NodeId id = 0;
  ClassId label = 0;
  bool stuff = false;
  Belief belief;
  Mat3 position_cov = Mat3::Zero();   // published covariance of the mean in the map, m^2
  std::vector<Belief> geometry = {};  // leaves, map frame
  bool dynamic = false;               // the map says that it moves
};

struct PredictedGraph {
  std::vector<MappedObject> objects;
  std::map<ClassId, std::string> class_names;
  std::map<NodeId, std::int64_t> region_of = {};  // of the things that are in one
  std::shared_ptr<const Map> map = {};            // that they come from; null for a graph JSON
};

/// The object as seen from another frame, geometry included.
MappedObject transform(const Pose& T_a_b, const MappedObject& object);

/// Both readers refuse ids that appear twice and numbers without a meaning: kappa of 0 or less, covariances that are
/// not finite, not symmetric or not positive semi-definite (a zero one is fine). The nodes of a map.hgg that it
/// confirms, with their leaves.
Result<PredictedGraph> readMapObjects(const std::filesystem::path& path);
/// Objects of a Graph JSON, version 1. Without "position_cov" it is cov / kappa; "geometry" may be missing. Labels
/// are whole numbers 0..65535.
Result<PredictedGraph> readGraphJson(const std::filesystem::path& path);

}  // namespace hgg
