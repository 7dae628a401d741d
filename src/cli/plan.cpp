#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.h"
#include "config.h"
#include "map/file.h"
#include "traversability/planner.h"

namespace hgg {
namespace {

struct PlanOptions {
  std::string map, config, batch;
  std::vector<double> from, to;
  std::optional<double> resolution;  // m
  double tolerance = kPlanTolerance;
  bool allow_unknown = false, json = false;
};

std::string jsonOf(const Plan& plan) {
  nlohmann::ordered_json j;
  j["found"] = plan.found;
  j["path"] = nlohmann::ordered_json::array();
  for (const Vec3& p : plan.path) {
    j["path"].push_back({p.x(), p.y(), p.z()});
  }
  j["length"] = plan.length, j["cost"] = plan.cost;
  j["goal_distance"] = plan.goal_distance;
  j["worst_confidence"] = plan.worst_confidence;
  j["reason"] = plan.reason;
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void printPlan(const Plan& plan) {
  if (!plan.found) {
    fmt::print("no path: {}\n", plan.reason);
    return;
  }
  fmt::print("path of {:.1f} m (cost {:.1f}), worst confidence {:.2f}\n", plan.length, plan.cost,
             plan.worst_confidence);
  if (plan.goal_distance > 0) {
    fmt::print("it ends {:.2f} m from the goal, where the robot cannot stand\n", plan.goal_distance);
  }
  for (const Vec3& p : plan.path) {
    fmt::print("  {:.2f} {:.2f} {:.2f}\n", p.x(), p.y(), p.z());
  }
}

/// x,y or x,y,z as it came from the command line or a batch; nothing when it is neither.
std::optional<PlanPoint> pointOf(const std::vector<double>& v) {
  if ((v.size() != 2 && v.size() != 3) || !std::ranges::all_of(v, [](double x) { return std::isfinite(x); })) {
    return std::nullopt;
  }
  return PlanPoint{v[0], v[1], v.size() == 3 ? std::optional(v[2]) : std::nullopt};
}

/// The grid that paths are looked for in.
struct Ground {
  CostGrid grid;
  double height = 0;  // m
};

Result<Ground> groundOf(const std::string& path, const TraversabilityConfig& limits) {
  const Result<StoredMap> stored = loadMap(path);
  if (!stored) {
    return Result<Ground>::fail(stored.error);
  }
  const std::optional<GridRegion> region = regionOf(stored->map);
  const Result<GridShape> shape =
      region ? gridShape(*region, limits.resolution)
             : Result<GridShape>::fail(fmt::format("{}: the map is empty: there is no ground in it", path));
  if (!shape) {
    return Result<Ground>::fail(shape.error);
  }
  Ground ground{buildCostGrid(stored->map, *shape, limits)};
  ground.height = groundHeight(stored->map, ground.grid);
  return Result<Ground>::ok(std::move(ground));
}

int planBatch(const PlanOptions& o, const Ground& ground, const TraversabilityConfig& limits) {
  const auto answer = [&](const nlohmann::json& line) -> std::optional<std::string> {
    const auto point = [&](const char* key) {
      const std::optional<std::vector<double>> numbers = numbersOf(line, key);
      return numbers ? pointOf(*numbers) : std::nullopt;
    };
    const std::optional<PlanPoint> from = point("from"), to = point("to");
    return from && to ? std::optional(jsonOf(
                            planPath(ground.grid, limits, {*from, *to, ground.height, o.allow_unknown, o.tolerance})))
                      : std::nullopt;
  };
  const auto refuse = [](const std::string& why) {
    Plan none;
    none.reason = why;
    return jsonOf(none);
  };
  return answerLines(o.batch, R"({"from":[x,y] or [x,y,z],"to":[..]})", answer, refuse);
}

int plan(const PlanOptions& o) {
  const Result<LoadedConfig> config = loadConfig(o.config);
  if (!config) {
    return fail(config.error);
  }
  TraversabilityConfig limits = config->config.traversability;
  limits.resolution = o.resolution.value_or(limits.resolution);
  const std::optional<PlanPoint> from = pointOf(o.from), to = pointOf(o.to);
  if (o.batch.empty() && (!from || !to)) {
    return fail("plan needs --from x,y[,z] and --to x,y[,z], or --batch FILE (see --help)");
  }
  const Result<Ground> ground = groundOf(o.map, limits);
  if (!ground) {
    return fail(ground.error);
  }
  if (!o.batch.empty()) {
    return planBatch(o, *ground, limits);
  }
  const Plan found = planPath(ground->grid, limits, {*from, *to, ground->height, o.allow_unknown, o.tolerance});
  if (o.json) {
    fmt::print("{}\n", jsonOf(found));
  } else {
    printPlan(found);
  }
  return found.found ? kDone : kNo;
}

}  // namespace

void addPlan(CLI::App& app, Action& action) {
  const auto o = std::make_shared<PlanOptions>();
  CLI::App* command = app.add_subcommand("plan", "Find a path that a legged robot can walk, or say why there is none");
  command->add_option("MAP", o->map, "map.hgg")->required();
  command->add_option("--from", o->from, "x,y[,z] in the map frame [m]; without z the ground the robot mapped")
      ->delimiter(',')
      ->expected(1, 3);
  command->add_option("--to", o->to, "x,y[,z] in the map frame [m]")->delimiter(',')->expected(1, 3);
  command->add_option("--batch", o->batch,
                      R"(file of lines {"from":[x,y,z],"to":[x,y,z]}: one JSON answer a line, in their order)");
  command->add_option("--config", o->config, "hggmap.toml with the robot's limits, [traversability]");
  command->add_option("--resolution", o->resolution, "edge of a cell [m]; default: as configured");
  command
      ->add_option("--tolerance", o->tolerance,
                   "where the robot cannot stand at an end of the path, how far off it may begin or end [m]")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command->add_flag("--allow-unknown", o->allow_unknown, "walk where nothing was seen, too");
  command->add_flag("--json", o->json, "print JSON");
  command->footer(
      "Exit status 1: there is no path.\nExample:\n  hggmap plan maps/drive/map.hgg --from 0,0 --to 12.5,-3");
  command->callback([o, &action] { action = [o] { return plan(*o); }; });
}

}  // namespace hgg
