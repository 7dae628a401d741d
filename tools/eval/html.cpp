#include "eval/html.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/spd.h"
#include "eval/report.h"
#include "page_parts.h"

namespace hgg {
namespace {

using nlohmann::json;

constexpr std::size_t kPathPoints = 1500;
constexpr std::size_t kWallCells = 9000;
constexpr double kUpright = 0.5;  // walls: leaves whose normal is at least 60 degrees off the vertical

double rounded(double x) { return std::round(x * 1000) / 1000; }

json point(const Vec3& p) { return {rounded(p.x()), rounded(p.y()), rounded(p.z())}; }

json horizontal(const Mat3& cov) { return {cov(0, 0), cov(0, 1), cov(1, 1)}; }

const ObjectMatch* findMatch(const std::vector<ObjectMatch>& matches, auto ObjectMatch::*key, auto id) {
  const auto match = std::ranges::find(matches, id, key);
  return match == matches.end() ? nullptr : &*match;
}

json truthObjects(const Evaluation& e) {
  json list = json::array();
  for (const TruthObject& object : e.scenery.truth) {
    if (!e.objects.classes.contains(object.label)) {
      continue;  // not asked for
    }
    const bool is_found = findMatch(e.objects.overall.matches, &ObjectMatch::truth, object.id) != nullptr;
    list.push_back({{"id", object.id},
                    {"name", className(e, object.label)},
                    {"mean", point(object.belief.mean)},
                    {"cov", horizontal(object.belief.cov)},
                    {"points", object.belief.kappa},
                    {"frames", object.frames},
                    {"state", object.dynamic || object.gone ? "moving"
                              : is_found                    ? "found"
                                                            : "missed"}});
  }
  return list;
}

json predictedObjects(const Evaluation& e) {
  json list = json::array();
  for (const MappedObject& object : e.scenery.predictions) {
    if (object.stuff || !e.objects.classes.contains(object.label)) {
      continue;
    }
    const ObjectMatch* match = findMatch(e.objects.overall.matches, &ObjectMatch::prediction, object.id);
    const bool is_moving = findMatch(e.objects.dynamic, &ObjectMatch::prediction, object.id) != nullptr;
    json entry{{"id", object.id},
               {"name", className(e, object.label)},
               {"mean", point(object.belief.mean)},
               {"cov", horizontal(object.belief.cov)},
               {"kappa", object.belief.kappa},
               {"state", match != nullptr              ? "found"
                         : is_moving || object.dynamic ? "moving"
                                                       : "ghost"}};
    if (const auto ghost = std::ranges::find(e.ghosts, object.id, &Ghost::prediction); ghost != e.ghosts.end()) {
      entry["cause"] = nameOf(ghost->cause);
    }
    if (match != nullptr) {
      entry.update({{"truth", match->truth}, {"distance", match->distance}, {"extent_error", match->extent_error}});
    }
    list.push_back(std::move(entry));
  }
  return list;
}

/// Every n-th of `size`, the last one included, at most kPathPoints or so.
std::vector<std::size_t> thinned(std::size_t size) {
  std::vector<std::size_t> kept;
  const std::size_t step = size / kPathPoints + 1;
  for (std::size_t i = 0; i < size; i += step) {
    kept.push_back(i);
  }
  if (size > 0 && kept.back() != size - 1) {
    kept.push_back(size - 1);
  }
  return kept;
}

json line(const Path& path, bool truth) {
  json points = json::array();
  for (const std::size_t i : thinned(path.pairs.size())) {
    const PosePair& pair = path.pairs[i];
    const Vec3 p =
        truth ? Vec3(pair.T_truth_body.translation()) : path.T_truth_estimate * pair.T_map_body.translation();
    points.push_back({rounded(p.x()), rounded(p.y())});
  }
  return points;
}

json errorCurve(const Path& path) {
  const std::vector<double> errors = positionErrors(path.pairs);
  json points = json::array();
  for (const std::size_t i : thinned(errors.size())) {
    points.push_back({i, rounded(errors[i])});
  }
  return points;
}

std::vector<Vec3> uprightLeaves(const std::vector<MappedObject>& predictions) {
  std::vector<Vec3> points;
  for (const MappedObject& object : predictions) {
    for (const Belief& leaf : object.stuff ? object.geometry : std::vector<Belief>()) {
      if (std::abs(eigenSymmetric(leaf.cov).vectors(2, 0)) < kUpright) {
        points.push_back(leaf.mean);
      }
    }
  }
  return points;
}

/// What stands and is no thing, as cells of a horizontal grid: as coarse as it takes to stay few.
json walls(const std::vector<MappedObject>& predictions) {
  const std::vector<Vec3> points = uprightLeaves(predictions);
  std::set<std::pair<std::int64_t, std::int64_t>> cells;
  double cell = 0.125;
  do {
    cell *= 2;
    cells.clear();
    for (const Vec3& p : points) {
      cells.emplace(std::llround(std::floor(p.x() / cell)), std::llround(std::floor(p.y() / cell)));
    }
  } while (cells.size() > kWallCells);
  json xy = json::array();
  for (const auto& [x, y] : cells) {
    xy.push_back(x);
    xy.push_back(y);
  }
  return {{"cell", cell}, {"xy", std::move(xy)}};
}

json sceneryOf(const Evaluation& e) {
  json paths = json::object(), errors = json::object();
  if (e.scenery.corrected) {
    paths["true"] = line(*e.scenery.corrected, true);
    paths["corrected"] = line(*e.scenery.corrected, false);
    errors["corrected"] = errorCurve(*e.scenery.corrected);
  }
  if (e.scenery.odometry) {
    paths["odometry"] = line(*e.scenery.odometry, false);
    errors["odometry"] = errorCurve(*e.scenery.odometry);
  }
  return {{"truth", truthObjects(e)},
          {"predictions", predictedObjects(e)},
          {"paths", std::move(paths)},
          {"errors", std::move(errors)},
          {"walls", walls(e.scenery.predictions)}};
}

void replace(std::string& text, const std::string& placeholder, const std::string& with) {
  text.replace(text.find(placeholder), placeholder.size(), with);
}

/// JSON that can stand inside a script element: no text in it can end the element. What is no UTF-8 is replaced.
std::string embedded(const json& data) {
  std::string text = data.dump(-1, ' ', false, json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

}  // namespace

std::string htmlReport(const Evaluation& evaluation, const std::string& title) {
  json data = toJson(evaluation);
  data["title"] = title;
  data["scenery"] = sceneryOf(evaluation);
  std::string page = kPageHtml;
  replace(page, "/*STYLE*/", kPageStyle);
  replace(page, "/*SCRIPT*/", std::string(kPageCharts) + kPageScript);
  replace(page, "/*DATA*/", embedded(data));
  return page;
}

}  // namespace hgg
