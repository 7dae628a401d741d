#include <CLI/CLI.hpp>
#include <cstdio>

#include "sim/simulate.h"

namespace {

constexpr int kBadInput = 2;

struct Arguments {
  std::string world, log, truth;
  double drift_percent = 0;
  hgg::SimOptions options;
};

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-sim: %s\n", error.c_str());
  return kBadInput;
}

void addOptions(CLI::App& app, Arguments& args) {
  hgg::SimOptions& options = args.options;
  app.add_option("WORLD", args.world, "world to drive through")->required()->check(CLI::IsMember(hgg::sceneNames()));
  app.add_option("-o,--output", args.log, "LCM log to write")->required()->type_name("LOG");
  app.add_option("--truth", args.truth, "truth directory to write: gt_objects.json, poses.txt")
      ->required()
      ->type_name("DIR");
  app.add_option("--seed", options.seed, "varies placement and noise")->capture_default_str();
  app.add_option("--frames", options.frames, "frames at 10 Hz")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--beams", options.lidar.beams, "beams of the LiDAR")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--drift", args.drift_percent, "odometry error in percent of the distance travelled")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  app.add_flag("--instances", options.instances, "put object ids on the points");
  app.footer(
      "Example:\n  hgg-sim yard -o yard.lcm --truth yard_truth --seed 1\nExit codes: 0 done, 2 bad input or usage.");
}

int run(Arguments args) {
  args.options.odometry = hgg::driftOf(args.drift_percent);
  const auto scene = hgg::makeScene(args.world, args.options.seed);
  hgg::ProgressBar bar("simulate");
  const auto truth = hgg::simulate(*scene, args.options, args.log, onBar(bar));
  if (!truth) {
    return fail(truth.error);
  }
  const std::string error = hgg::writeTruth(truth->objects, truth->T_map_body, args.truth);
  return error.empty() ? 0 : fail(error);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("hgg-sim: drives a LiDAR through a made-up world: LCM log for hggmap, truth for hgg-eval");
  Arguments args;
  addOptions(app, args);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + " (see --help)");
  }
  return run(std::move(args));
}
