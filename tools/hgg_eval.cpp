#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "eval/report.h"

namespace {

constexpr int kBadInput = 2;

constexpr const char* kHelp = R"(hgg-eval: compares a map with the truth.

Objects: each (map object, true object) pair of the same class within the radius is a candidate; the closest is taken first,
each object at most once. Matched = found, true objects left = missed, map objects left = ghosts. Only things count; true
objects that move are left out, and a map object that matches one of them is neither found nor a ghost.
Trajectory: with --trajectory the map is first laid over the truth by the rigid transform between estimated and true poses
(mean rotation, mean position), because a map may start anywhere; the ATE is the usual RMSE after its own best fit.)";

constexpr const char* kFooter = R"(Examples:
  hgg-eval --map out/map.hgg --truth yard_truth
  hgg-eval --map out/map.hgg --truth truth --trajectory out/trajectory.tum --poses poses.txt --class car --radius 1.5
Exit codes: 0 done, 2 bad input or usage.)";

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-eval: %s\n", error.c_str());
  return kBadInput;
}

void addOptions(CLI::App& app, hgg::EvalOptions& options, bool& json) {
  auto* map = app.add_option("--map", options.map, "map.hgg to evaluate")->type_name("FILE");
  auto* graph = app.add_option("--graph", options.graph, "graph JSON to evaluate instead")->type_name("FILE");
  map->excludes(graph);
  app.add_option("--truth", options.truth, "truth directory: gt_objects.json, poses.txt")->required()->type_name("DIR");
  auto* trajectory =
      app.add_option("--trajectory", options.trajectory, "estimated trajectory (TUM)")->type_name("FILE");
  auto* poses = app.add_option("--poses", options.poses, "true poses, 3x4 rows [DIR/poses.txt]")->type_name("FILE");
  auto* times =
      app.add_option("--times", options.times, "times of the true poses in seconds, when their count differs");
  times->type_name("FILE")->needs(trajectory);
  poses->needs(trajectory);
  app.add_option("--radius", options.radius, "m, how far a match may be away")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--class", options.classes, "evaluate these classes only (names or ids)")->type_name("NAME");
  app.add_flag("--json", json, "print JSON");
  app.footer(kFooter);
}

int run(const hgg::EvalOptions& options, bool json) {
  if (options.map.empty() && options.graph.empty()) {
    return fail("give a map with --map or --graph (see --help)");
  }
  const auto evaluation = hgg::evaluate(options);
  if (!evaluation) {
    return fail(evaluation.error);
  }
  const std::string text = json ? toJson(*evaluation).dump(2) + "\n" : formatTable(*evaluation);
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kHelp);
  hgg::EvalOptions options;
  bool json = false;
  addOptions(app, options, json);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + " (see --help)");
  }
  return run(options, json);
}
