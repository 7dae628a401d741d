#include "eval/evaluate.h"

#include <charconv>

#include "eval/trajectory.h"
#include "truth/poses.h"

namespace hgg {
namespace {

std::optional<ClassId> findClass(const std::string& name, const std::map<ClassId, std::string>& names) {
  for (const auto& [id, known] : names) {
    if (known == name) {
      return id;
    }
  }
  ClassId id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc() && end == name.data() + name.size() ? std::optional(id) : std::nullopt;
}

Result<std::set<ClassId>> findClasses(const std::vector<std::string>& names,
                                      const std::map<ClassId, std::string>& known) {
  std::set<ClassId> classes;
  for (const std::string& name : names) {
    const auto id = findClass(name, known);
    if (!id) {
      return Result<std::set<ClassId>>::fail("the map knows no class \"" + name + "\"");
    }
    classes.insert(*id);
  }
  return Result<std::set<ClassId>>::ok(std::move(classes));
}

Result<std::optional<std::vector<Micros>>> truthTimes(const std::filesystem::path& path) {
  using Times = Result<std::optional<std::vector<Micros>>>;
  if (path.empty()) {
    return Times::ok(std::nullopt);
  }
  auto times = readTimes(path);
  return times ? Times::ok(std::move(times.value)) : Times::fail(times.error);
}

Result<std::optional<TrajectoryScore>> scoreTrajectory(const EvalOptions& options) {
  using Score = Result<std::optional<TrajectoryScore>>;
  if (options.trajectory.empty()) {
    return Score::ok(std::nullopt);
  }
  const auto estimate = readTum(options.trajectory);
  const auto truth = readPoses(options.poses.empty() ? options.truth / "poses.txt" : options.poses);
  const auto times = truthTimes(options.times);
  if (!estimate || !truth || !times) {
    return Score::fail(!estimate ? estimate.error : !truth ? truth.error : times.error);
  }
  const auto pairs = pairPoses(*estimate, *truth, *times);
  if (!pairs) {
    return Score::fail(pairs.error);
  }
  return Score::ok(TrajectoryScore{pairs->size(), absoluteTrajectoryError(*pairs), alignMap(*pairs)});
}

}  // namespace

Result<Evaluation> evaluate(const EvalOptions& options) {
  using Evaluated = Result<Evaluation>;
  auto graph = options.map.empty() ? readGraphJson(options.graph) : readMapObjects(options.map);
  if (!graph) {
    return Evaluated::fail(graph.error);
  }
  const auto truth = readTruthObjects(options.truth / "gt_objects.json");
  const auto only = findClasses(options.classes, graph->class_names);
  const auto trajectory = scoreTrajectory(options);
  if (!truth || !only || !trajectory) {
    return Evaluated::fail(!truth ? truth.error : !only ? only.error : trajectory.error);
  }
  if (*trajectory) {
    for (Prediction& object : graph->objects) {
      object.belief = transform((*trajectory)->T_truth_map, object.belief);
    }
  }
  auto objects = evaluateObjects(graph->objects, *truth, options.radius, *only);
  return Evaluated::ok({options.radius, std::move(graph->class_names), std::move(objects), *trajectory});
}

}  // namespace hgg
