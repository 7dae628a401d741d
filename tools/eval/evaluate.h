#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/objects.h"

namespace hgg {

struct EvalOptions {
  std::filesystem::path map, graph;  // one of them: map.hgg or graph JSON
  std::filesystem::path truth;       // directory with gt_objects.json
  std::filesystem::path trajectory;  // TUM; empty: the map's frame is taken to be the truth's
  std::filesystem::path poses;       // true poses; empty: truth/poses.txt
  std::filesystem::path times;       // of the true poses; empty: they pair with the trajectory row by row
  double radius = 1.5;               // m
  std::vector<std::string> classes;  // names or ids; empty: all
};

struct TrajectoryScore {
  std::size_t pairs = 0;
  double ate = 0;                       // m
  Pose T_truth_map = Pose::Identity();  // applied to the predictions before matching
};

struct Evaluation {
  double radius = 0;
  std::map<ClassId, std::string> class_names;
  ObjectEvaluation objects;
  std::optional<TrajectoryScore> trajectory;
};

/// Reads what the options name and scores it.
Result<Evaluation> evaluate(const EvalOptions& options);

}  // namespace hgg
