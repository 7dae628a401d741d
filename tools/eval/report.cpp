#include "eval/report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace hgg {
namespace {

using nlohmann::json;

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  char line[256];
  std::snprintf(line, sizeof line, pattern, args...);
  return line;
}

std::string className(const Evaluation& evaluation, ClassId label) {
  const auto name = evaluation.class_names.find(label);
  return name == evaluation.class_names.end() ? "class " + std::to_string(label) : name->second;
}

std::string number(double value) { return std::isnan(value) ? "-" : format("%.3f", value); }

std::string formatRow(const std::string& name, const ObjectScore& s) {
  return format("%-16s %6zu %6zu %6zu %6zu %10s %8s %8s %8s %8s %8s\n", name.c_str(), s.truth, s.matches.size(),
                s.missed.size(), s.ghosts.size(), number(s.precision()).c_str(), number(s.recall()).c_str(),
                number(s.f1()).c_str(), number(s.meanError()).c_str(), number(s.medianError()).c_str(),
                number(s.maxError()).c_str());
}

std::string formatTrajectory(const TrajectoryScore& t) {
  const Vec3 p = t.T_truth_map.translation();
  const double degrees = Eigen::AngleAxisd(t.T_truth_map.linear()).angle() * 180.0 / M_PI;
  return format(
      "trajectory: ATE %.3f m over %zu poses; map moved by %.3f %.3f %.3f m and turned by %.3f deg before matching\n",
      t.ate, t.pairs, p.x(), p.y(), p.z(), degrees);
}

json toJson(const std::vector<Match>& matches) {
  json list = json::array();
  for (const Match& match : matches) {
    list.push_back({{"id", match.prediction}, {"truth", match.truth}, {"distance", match.distance}});
  }
  return list;
}

json toJson(const ObjectScore& s) {
  return {{"truth", s.truth},
          {"predicted", s.predicted},
          {"true_positives", s.matches.size()},
          {"precision", s.precision()},
          {"recall", s.recall()},
          {"f1", s.f1()},
          {"position_error", {{"mean", s.meanError()}, {"median", s.medianError()}, {"max", s.maxError()}}},
          {"matches", toJson(s.matches)},
          {"missed", s.missed},
          {"ghosts", s.ghosts}};
}

json toJson(const TrajectoryScore& t) {
  json rows = json::array();
  for (int i = 0; i < 12; ++i) {
    rows.push_back(t.T_truth_map.matrix()(i / 4, i % 4));
  }
  return {{"pairs", t.pairs}, {"ate_rmse", t.ate}, {"T_truth_map", rows}};
}

}  // namespace

std::string formatTable(const Evaluation& evaluation) {
  std::string text = format("objects: things of the same class within %g m; position error in m\n", evaluation.radius);
  text += format("%-16s %6s %6s %6s %6s %10s %8s %8s %8s %8s %8s\n", "class", "true", "found", "missed", "ghosts",
                 "precision", "recall", "F1", "mean", "median", "max");
  for (const auto& [label, score] : evaluation.objects.classes) {
    text += formatRow(className(evaluation, label), score);
  }
  text += formatRow("all", evaluation.objects.overall);
  if (!evaluation.objects.dynamic.empty()) {
    text += format("%zu predictions of moving objects set aside\n", evaluation.objects.dynamic.size());
  }
  return evaluation.trajectory ? text + formatTrajectory(*evaluation.trajectory) : text;
}

json toJson(const Evaluation& evaluation) {
  json classes = json::array();
  for (const auto& [label, score] : evaluation.objects.classes) {
    json entry = toJson(score);
    entry["label"] = label;
    entry["name"] = className(evaluation, label);
    classes.push_back(std::move(entry));
  }
  return {{"radius", evaluation.radius},
          {"classes", std::move(classes)},
          {"overall", toJson(evaluation.objects.overall)},
          {"dynamic", toJson(evaluation.objects.dynamic)},
          {"trajectory", evaluation.trajectory ? toJson(*evaluation.trajectory) : json()}};
}

}  // namespace hgg
