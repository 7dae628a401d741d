#include "eval/plans.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

namespace hgg {
namespace {

using nlohmann::json;

Vec3 pointOf(const json& numbers) {
  return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}
json toJson(const Vec3& p) { return json::array({p.x(), p.y(), p.z()}); }

/// Reads a JSON value a line.
template <typename T>
Result<std::vector<T>> readLines(const std::filesystem::path& path, const std::function<T(const json&)>& parse) {
  using Values = Result<std::vector<T>>;
  std::ifstream in(path);
  if (!in) {
    return Values::fail("cannot read " + path.string());
  }
  std::vector<T> values;
  for (std::string line; std::getline(in, line);) {
    try {
      values.push_back(parse(json::parse(line)));
    } catch (const json::exception& e) {
      return Values::fail(path.string() + ":" + std::to_string(values.size() + 1) + ": " + e.what());
    }
  }
  return Values::ok(std::move(values));
}

double lengthOf(const std::vector<Vec3>& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length += (path[i] - path[i - 1]).norm();
  }
  return length;
}

bool leadsFromTo(const PlanAnswer& answer, const PlanPair& request) {
  constexpr double kThere = 0.5;  // m
  return answer.found && !answer.path.empty() && (answer.path.front() - request.from).norm() < kThere &&
         (answer.path.back() - request.to).norm() < kThere;
}

/// What a path meets in the truth.
struct Met {
  bool blocked = false, nothing = false;
};

Met walk(const std::vector<Vec3>& path, const WalkGrid& truth, const Laying& laying) {
  constexpr double kStep = 0.05;  // m
  Met met;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3& from = path[i > 0 ? i - 1 : 0];
    const int steps = std::max(1, static_cast<int>(std::ceil((path[i] - from).norm() / kStep)));
    for (int k = 1; k <= steps; ++k) {
      const Vec3 p = truth.T_grid_map * laying.toTruth(from + (path[i] - from) * (static_cast<double>(k) / steps));
      const auto cell = truth.cellOf(p.x(), p.y());
      if (!cell || truth.known[*cell] == 0) {
        continue;
      }
      const auto surface = surfaceNear(truth, *cell, p.z(), kSameSurface);
      met.nothing = met.nothing || !surface;
      met.blocked = met.blocked || (surface && truth.surfaces[*surface].standing == Standing::kBlocked);
    }
  }
  return met;
}

}  // namespace

std::vector<PlanPair> drawPlans(const WalkGrid& truth, const Walker& walker, const Laying& laying, int count,
                                std::uint64_t seed) {
  constexpr double kApart = 2.0;  // m
  constexpr int kTries = 100;     // a request, before there is taken to be no room for any
  const WalkPaths paths(truth, walker);
  const auto& ground = paths.ground();
  std::mt19937_64 random(seed);
  const Pose T_truth_grid = truth.T_grid_map.inverse();
  const auto in_map = [&](std::uint32_t surface) { return laying.toMap(T_truth_grid * paths.place(surface)); };
  std::vector<PlanPair> requests;
  for (int tries = 0; !ground.empty() && static_cast<int>(requests.size()) < count && tries < kTries * count; ++tries) {
    const auto draw = [&] { return ground[random() % ground.size()]; };
    const std::uint32_t from = draw(), to = draw();
    if ((paths.place(from) - paths.place(to)).norm() < kApart) {
      continue;
    }
    if (const auto length = paths.shortest(from, to)) {
      requests.push_back({in_map(from), in_map(to), *length});
    }
  }
  return requests;
}

std::string writePlanRequests(const std::vector<PlanPair>& requests, const std::filesystem::path& path) {
  std::ofstream out(path);
  for (const PlanPair& r : requests) {
    out << json{{"from", toJson(r.from)}, {"to", toJson(r.to)}, {"shortest", r.shortest}}.dump() << "\n";
  }
  out.close();
  return out ? "" : "cannot write " + path.string();
}

Result<std::vector<PlanPair>> readPlanRequests(const std::filesystem::path& path) {
  return readLines<PlanPair>(path, [](const json& line) {
    return PlanPair{pointOf(line.at("from")), pointOf(line.at("to")), line.at("shortest")};
  });
}

Result<std::vector<PlanAnswer>> readPlanAnswers(const std::filesystem::path& path) {
  return readLines<PlanAnswer>(path, [](const json& line) {
    PlanAnswer answer{line.at("found"), {}};
    for (const json& p : line.value("path", json::array())) {
      answer.path.push_back(pointOf(p));
    }
    return answer;
  });
}

PlanScore scorePlans(const std::vector<PlanPair>& requests, const std::vector<PlanAnswer>& answers,
                     const WalkGrid& truth, const Laying& laying) {
  PlanScore score;
  score.asked = requests.size();
  double sum = 0;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    if (!leadsFromTo(answers[i], requests[i])) {
      continue;
    }
    const Met met = walk(answers[i].path, truth, laying);
    // A path may begin or end beside the place that was asked for: the rest counts as walked.
    const std::vector<Vec3>& path = answers[i].path;
    const double rest = (path.front() - requests[i].from).norm() + (path.back() - requests[i].to).norm();
    const double ratio = (lengthOf(path) + rest) / requests[i].shortest;
    ++score.found;
    score.through_blocked += met.blocked ? 1 : 0;
    score.off_ground += met.nothing ? 1 : 0;
    score.longer += ratio > kLongest ? 1 : 0;
    sum += ratio;
    score.worst_ratio = std::max(score.worst_ratio, ratio);
  }
  score.mean_ratio = sum / static_cast<double>(score.found);
  score.worst_ratio = score.found > 0 ? score.worst_ratio : score.mean_ratio;
  return score;
}

}  // namespace hgg
