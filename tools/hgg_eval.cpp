#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "eval/html.h"
#include "eval/report.h"

namespace {

constexpr int kBadInput = 2;

constexpr const char* kHelp = R"(hgg-eval: compares a map with the truth.

Objects: each (map object, true object) pair of the same class within the radius is a candidate; the closest is taken
first, each object at most once. Matched = found, true objects left = missed, map objects left = ghosts. Only things
count, and a class with true objects is one of things whatever the map says; true objects that move or are taken away
are left out, and a map object that matches one of them is set aside: neither found nor a ghost.
Ghosts are told by what they come from: a second node or a piece of a thing that is found; left by something that moves (on
its track); of a thing that was taken away; on a surface of another class (by cloud.ply); or at nothing. Twins are pairs of
map objects of one class within 0.5 m whose nearest true object is the same. Map objects that are called dynamic are neither
found nor ghosts; told is how many of what moves is, and how many of what stays.
Calibration: normalised squared errors under the published covariances, of matches only, so none is farther off than
the radius: what is lost is not in it. Mean sigma (m) says how sharp the beliefs are; honest ones can be vague. Errors are
taken in the frame of the map's first pose, which the published covariance speaks of, not after the best fit. Neighbours:
the same of differences of two positions, of all pairs within 30 m (a map.hgg only).
Live poses: as they were published, where the run left them (live.tum, with the status), else as corrected later; the map
is laid over the truth at the first pose. Right is within 0.3 m, and back when it stays so for 5 s.
Trajectory: with --trajectory the map is first laid over the truth by the rigid transform between estimated and true
poses (mean rotation, mean position), because a map may start anywhere; the ATE is the usual RMSE after its own best
fit. The share of true poses that are scored is reported; below 0.95 with a warning, as poses left out cannot count as
wrong.
Geometry, where the truth has cloud.ply: points of the leaves against the cloud, cropped to 3 m around them, aligned.
Accuracy alone can be fooled by leaving surface out: read it with completeness and with coverage, the share of the
reference within 20 m of the path that the crop keeps. Leaves farther than 20 m from the path are left out; their
share is reported. Vegetation is left out, by the class names in the truth's classes.toml where it has one, else by
the map's.
Loops, with --trajectory, where stats.json tells of them: every accepted loop against the true motion between its two
keyframes; more than 1 m or 3 degrees off is false. A revisit is a stretch of the true way within 10 m of a place left
more than 100 m of way before (with a radius below 1 m, so indoors: 3 m and 15 m); it is closed when a loop that is not
false comes of a keyframe within it, or up to 30 m (5 m) before or after its beginning: a place is seen before it is
reached. Revisits that are not closed need not be missed: where alignment never lost the old part of the map there is
no loop to ask for. So the questions asked are told too.
Grid, with --grid: where the map says one can walk, against the truth's walk_grid.json. Asked are cells of the ground that
a beam came back from; those nearer to a limit than range noise can tell (2 cm, 2 degrees) count neither way. Surfaces of one
cell are told apart by height (0.3 m). Blocked: the share of truly blocked cells the map calls walkable. Precision: the share
of its walkable cells, touched or not, that can be walked on; islands such as table tops, to which no step leads, are left
out and counted. Recall: of truly free cells within 12 m of the way, those it calls walkable. Once cell for cell and once
right when any of the 3 x 3 cells is; and both again with the map laid over the truth by the nearest pose.
Plans: --plans draws pairs on the largest connected part of the seen ground on which a robot of 0.3 m radius keeps 0.1 m
away from everything, so each has an answer. A path must not touch truly blocked cells; its length is held against the
shortest on the truth.
Retrieval: the answers of hggmap query --batch TRUTH/queries.jsonl. Cost: stats.json.)";

constexpr const char* kFooter = R"(Examples:
  hgg-eval --map out/map.hgg --truth yard_truth --html report.html
  hgg-eval --map out/map.hgg --truth truth --trajectory out/trajectory.tum --log drive.lcm --class car --radius 1.5
Exit codes: 0 done, 2 bad input or usage.)";

struct Arguments {
  hgg::EvalOptions options;
  bool json = false;
  std::string html, title;
};

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-eval: %s\n", error.c_str());
  return kBadInput;
}

/// CLI's own checks let NaN pass.
const CLI::Validator kFinite(
    [](const std::string& text) {
      double value = 0;
      const bool is_number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
      return is_number ? std::string() : text + " is not a finite number";
    },
    "");

void addInputs(CLI::App& app, hgg::EvalOptions& options) {
  auto* map = app.add_option("--map", options.map, "map.hgg to evaluate")->type_name("FILE");
  auto* graph = app.add_option("--graph", options.graph, "graph JSON to evaluate instead")->type_name("FILE");
  map->excludes(graph);
  app.add_option("--truth", options.truth,
                 "truth directory: gt_objects.json, poses.txt, cloud.ply, queries.jsonl, classes.toml")
      ->required()
      ->type_name("DIR");
  auto* trajectory =
      app.add_option("--trajectory", options.trajectory, "estimated trajectory (TUM)")->type_name("FILE");
  auto* poses = app.add_option("--poses", options.poses, "true poses, 3x4 rows [DIR/poses.txt]")->type_name("FILE");
  auto* times = app.add_option("--times", options.times,
                               "times of the true poses in seconds, when their count differs [DIR/times.txt]");
  auto* log = app.add_option("--log", options.log, "the mapper's input: scores its odometry too")->type_name("LOG");
  app.add_option("--odometry-channel", options.odometry_channel, "in that log")->needs(log)->capture_default_str();
  app.add_option("--cloud-channel", options.cloud_channel, "in that log")->needs(log)->capture_default_str();
  times->type_name("FILE")->needs(trajectory);
  poses->needs(trajectory);
  log->needs(trajectory);
  app.add_option("--live", options.live,
                 "poses as they were published: TUM with the status behind [live.tum beside the trajectory]")
      ->type_name("FILE")
      ->needs(trajectory);
  app.add_option("--fault", options.fault,
                 "when something went wrong, s after the start: tells how long until it is right")
      ->type_name("S")
      ->check(kFinite)
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--stats", options.stats, "cost of the run [stats.json beside the map]")->type_name("FILE");
  app.add_option("--grid", options.grid, "of where one can walk: FILE.layers.json of hggmap export --format grid")
      ->type_name("FILE");
  auto* requests = app.add_option("--plan-requests", options.plan_requests,
                                  "pairs to plan between: written with --plans, read with --plan-answers");
  auto* answers = app.add_option("--plan-answers", options.plan_answers, "of hggmap plan --json, a line a request");
  app.add_option("--plans", options.plans, "draw so many pairs on ground that was seen")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->needs(requests)
      ->excludes(answers);
  requests->type_name("FILE");
  answers->type_name("FILE")->needs(requests);
  app.add_option("--answers", options.answers, "of hggmap query --batch to the truth's queries")->type_name("FILE");
}

void addOptions(CLI::App& app, Arguments& args) {
  addInputs(app, args.options);
  app.add_option("--radius", args.options.radius, "m, how far a match may be away")
      ->check(CLI::PositiveNumber)
      ->check(kFinite)
      ->capture_default_str();
  app.add_option("--spacing", args.options.spacing, "m, between the points geometry is compared over")
      ->check(CLI::Range(0.005, 10.0))
      ->check(kFinite)
      ->capture_default_str();
  app.add_option("--class", args.options.classes, "evaluate these classes only (names or ids)")->type_name("NAME");
  app.add_flag("--json", args.json, "print JSON");
  auto* html = app.add_option("--html", args.html, "write a report to look at: one self-contained page");
  html->type_name("FILE");
  app.add_option("--title", args.title, "of the report [the map's path]")->needs(html);
  app.footer(kFooter);
}

/// An error line, empty when done.
std::string writePage(const Arguments& args, const hgg::Evaluation& evaluation) {
  const auto& map = args.options.map.empty() ? args.options.graph : args.options.map;
  std::ofstream out(args.html, std::ios::binary);
  out << htmlReport(evaluation, args.title.empty() ? map.string() : args.title);
  out.close();
  return out ? "" : "cannot write " + args.html;
}

int run(const Arguments& args) {
  if (args.options.map.empty() && args.options.graph.empty()) {
    return fail("give a map with --map or --graph (see --help)");
  }
  const auto evaluation = hgg::evaluate(args.options);
  if (!evaluation) {
    return fail(evaluation.error);
  }
  if (const std::string error = args.html.empty() ? "" : writePage(args, *evaluation); !error.empty()) {
    return fail(error);
  }
  const auto replace = nlohmann::json::error_handler_t::replace;  // what is no UTF-8, such as a broken class name
  const std::string text =
      args.json ? toJson(*evaluation).dump(2, ' ', false, replace) + "\n" : formatTable(*evaluation);
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kHelp);
  Arguments args;
  addOptions(app, args);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + " (see --help)");
  }
  return run(args);
}
