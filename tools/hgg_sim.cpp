#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <thread>

#include "sim/options.h"

namespace {

constexpr int kBadInput = 2;

constexpr const char* kAbout =
    R"(hgg-sim: drives sensors through a made-up world. Writes an LCM log for hggmap and a truth directory for hgg-eval
(gt_objects.json, poses.txt, cloud.ply, queries.jsonl, classes.toml, walk_grid.json). Sensors with cameras also write
<log stem>.rig.toml beside the log.)";

constexpr const char* kExamples = R"(Examples:
  hgg-sim --list
  hgg-sim street -o street.lcm --truth street_truth --seed 3
  hgg-sim office -o office.lcm --truth office_truth --sensor rgbd --labels poor --odometry excellent
  hgg-sim campus -o campus.lcm --truth campus_truth --sensor rig --cameras 2 --dynamics --motion-distortion
  hgg-sim --path 07_gt.txt 07_odometry.txt -o 07.lcm --truth 07_truth
  hgg-sim street -o late.lcm --truth late_truth --every 2 --odometry-delay 0.1 --odometry-fault slip@20
  hgg-sim hall -o carried.lcm --truth carried_truth --kidnap 40:15 --kidnap-odometry zero
Exit codes: 0 done, 2 bad input or usage.)";

struct Arguments {
  std::string log, truth;
  bool list = false;
  hgg::SimArguments sim;
};

int fail(const std::string& error) {
  std::fprintf(stderr, "hgg-sim: %s\n", error.c_str());
  return kBadInput;
}

std::vector<std::string> namesOf(const std::vector<hgg::SensorName>& sensors) {
  std::vector<std::string> names;
  for (const auto& sensor : sensors) {
    names.push_back(sensor.name);
  }
  return names;
}

/// A number from `lo` to `hi`; CLI::Range lets NaN pass.
CLI::Validator within(double lo, double hi) {
  const CLI::Range range(lo, hi);
  const auto check = [lo, hi, name = range.get_description()](const std::string& text) -> std::string {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(text, value);
    return is_number && value >= lo && value <= hi ? "" : text + " is not a number in " + name;
  };
  return {check, range.get_description()};
}

/// CLI reads -3 as a huge seed.
const CLI::Validator kNotNegative(
    [](const std::string& text) { return text.starts_with('-') ? text + " is negative" : std::string(); }, "");

void addWorldOptions(CLI::App& app, Arguments& args) {
  app.add_option("WORLD", args.sim.world, "world to drive through; --list names them");
  app.add_option("--path", args.sim.path,
                 "a world along a real way: true and odometry poses, KITTI camera frame, 10 Hz")
      ->expected(2)
      ->type_name("GT ODOM");
  app.add_flag("--list", args.list, "name the worlds and sensors");
  app.add_option("-o,--output", args.log, "LCM log to write")->type_name("LOG");
  app.add_option("--truth", args.truth, "truth directory to write")->type_name("DIR");
  app.add_option("--seed", args.sim.options.seed, "varies placement and noise")
      ->check(kNotNegative)
      ->capture_default_str();
  app.add_option("--noise-seed", args.sim.noise_seed,
                 "another drive through the same world: varies noise alone [--seed]")
      ->check(kNotNegative);
  app.add_option("--frames", args.sim.options.frames, "how many; 0: the world's whole tour")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app.add_option("--rate", args.sim.options.rate_hz, "frames a second")
      ->type_name("HZ")
      ->check(within(0.1, 100.0))
      ->capture_default_str();
  app.add_option("--every", args.sim.options.every, "of the frames every Nth is in the log; odometry likewise")
      ->type_name("N")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--kidnap", args.sim.kidnap,
                 "carried away after SECONDS, for 3 s, to a place METRES away where it has been [5 to 60], or to frame "
                 "FRAME of the tour")
      ->type_name("SECONDS[:METRES|@FRAME]");
  app.add_option("--kidnap-odometry", args.sim.kidnap_odometry,
                 "after it: goes on, starts at zero, or knows the true motion")
      ->check(CLI::IsMember({"on", "zero", "true"}))
      ->capture_default_str();
  app.add_flag("--dynamics{1.0}", args.sim.dynamics,
               "people and cars move, things change between laps; =SHARE (0..1) of the most the world has")
      ->check(within(0.0, 1.0));
  app.add_flag("--plates", args.sim.plates,
               "street and campus: also small signs (0.35 m) on poles; all else stays as it is without");
  app.add_flag("--gait", args.sim.gait, "the body rolls and pitches as on legs");
  app.add_option("--threads", args.sim.options.threads, "they change the time it takes, nothing else")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
}

void addSensorOptions(CLI::App& app, Arguments& args) {
  hgg::SimArguments& sim = args.sim;
  const auto share = within(0.0, 1.0);
  app.add_option("--sensor", sim.sensor, "what the body carries")
      ->check(CLI::IsMember(namesOf(hgg::sensorNames())))
      ->capture_default_str();
  app.add_option("--cameras", sim.cameras, "of the rig: front, left, right [3]")->check(CLI::Range(1, 3));
  app.add_flag("--semantic,!--no-semantic", sim.options.semantic_cloud,
               "with cameras: also write LIDAR_SEMANTIC, as a mapper makes it from the rest [on]");
  app.add_flag(
      "--perfect-transfer", sim.options.perfect_transfer,
      "of a rig: LIDAR_SEMANTIC has each return, with what the segmenter says of its object where a camera sees "
      "that: as if labels were carried over without a mistake");
  app.add_flag("--motion-distortion", sim.options.motion_distortion,
               "the LiDAR measures while the body moves; points carry their time");
  app.add_option("--range-noise", sim.range_noise, "standard deviation [the sensor's]")
      ->type_name("M")
      ->check(within(0.0, 10.0));
  app.add_option("--dropout", sim.dropout, "share of returns lost [the sensor's]")->check(share);
  app.add_option("--labels", sim.labels, "how well the segmenter works")
      ->check(CLI::IsMember({"perfect", "good", "poor"}))
      ->capture_default_str();
  app.add_option("--speckle", sim.speckle, "share of points with a random class [of --labels]")->check(share);
  app.add_option("--unknown", sim.unknown, "share of points without a class [of --labels]")->check(share);
  app.add_option("--bleed", sim.bleed, "share of border points with the neighbour's class [of --labels]")->check(share);
  app.add_option("--confusion", sim.confusion, "share of objects a frame of another class [of --labels]")->check(share);
  app.add_option(
         "--confusion-common", sim.confusion_common,
         "share of things, and of stretches of stuff, a frame that are taken for another common class of things, "
         "for 5 to 20 frames: things as a whole, of stuff a patch of 1 to 3 m")
      ->check(share)
      ->capture_default_str();
  app.add_option("--missed", sim.missed, "share of objects a frame without a class [of --labels]")->check(share);
  app.add_flag("--walk-grid,!--no-walk-grid", sim.options.walk_grid, "write the truth of where one can walk [on]");
  app.add_flag("--instances", sim.options.instances, "object ids on the points of things");
  app.add_option("--odometry", sim.odometry, "how well odometry works [good; --path: the file's]")
      ->check(CLI::IsMember(hgg::odometryPresetNames()));
  app.add_option("--odometry-dropout", sim.odometry_dropout, "share of odometry samples missing")
      ->check(within(0.0, 0.9))
      ->capture_default_str();
  app.add_option("--odometry-jumps", sim.odometry_jumps, "jumps in 100 m, of about 0.5 m and 3 degrees")
      ->check(within(0.0, 1000.0))
      ->capture_default_str();
}

void addFaultOptions(CLI::App& app, Arguments& args) {
  hgg::OdometryFaults& faults = args.sim.options.odometry_faults;
  app.add_option("--odometry-delay", faults.delay, "odometry's poses are late by this; negative: early")
      ->type_name("S")
      ->check(within(-10.0, 10.0))
      ->capture_default_str();
  app.add_option("--odometry-bursts", faults.bursts,
                 "in the N sharpest turns odometry leaves its track for 5 to 8 frames, by 6 degrees and 0.3 to 1 m")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_flag("--bursts-stay", faults.bursts_stay, "and does not come back to it");
  app.add_option(
         "--odometry-fault", args.sim.odometry_faults,
         "KIND jump (m), yaw-jump (deg), slip (share of the way, for 5 s), frozen (s), restart; or xyzw: quaternions "
         "in that order")
      ->type_name("KIND[:SIZE]@SECONDS");
}

int list() {
  std::printf("worlds:\n");
  for (const std::string& name : hgg::sceneNames()) {
    std::printf("  %s\n", name.c_str());
  }
  std::printf("sensors:\n");
  for (const auto& sensor : hgg::sensorNames()) {
    std::printf("  %-10s %s\n", sensor.name.c_str(), sensor.description.c_str());
  }
  return 0;
}

/// What is wrong with the arguments as a whole; empty when nothing is.
std::string contradiction(const Arguments& args) {
  if (args.sim.world.empty() == args.sim.path.empty()) {
    return "give a WORLD or --path GT ODOM (see --help, --list)";
  }
  if (args.log.empty()) {
    return "give the log to write: -o LOG";
  }
  if (args.truth.empty()) {
    return "give the truth directory to write: --truth DIR";
  }
  return "";
}

int run(const Arguments& args) {
  const auto scene = hgg::sceneOf(args.sim);
  if (!scene) {
    return fail(scene.error);
  }
  const auto options = hgg::simOptions(args.sim, *scene);
  if (!options) {
    return fail(options.error);
  }
  std::string error = hgg::prepareTruth(args.truth);
  if (!error.empty()) {
    return fail(error);
  }
  hgg::ProgressBar bar("simulate");
  const auto drive = hgg::simulate(*scene, *options, args.log, onBar(bar));
  if (!drive) {
    return fail(drive.error);
  }
  const auto truth = hgg::completeTruth(*scene, *drive, options->threads);
  error = hgg::writeTruth(truth, args.truth);
  if (!error.empty()) {
    return fail(error);
  }
  std::printf("%s: %zu frames; %s: %zu objects, %zu queries; labels are those of firmware_cfg/%s/classes.toml\n",
              args.log.c_str(), drive->T_map_body.size(), args.truth.c_str(), truth.objects.size(),
              truth.queries.size(), scene->label_space.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kAbout);
  Arguments args;
  args.sim.options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  addWorldOptions(app, args);
  addSensorOptions(app, args);
  addFaultOptions(app, args);
  app.footer(kExamples);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return e.get_exit_code() == 0 ? app.exit(e) : fail(std::string(e.what()) + " (see --help)");
  }
  if (args.list) {
    return list();
  }
  const std::string error = contradiction(args);
  return error.empty() ? run(args) : fail(error);
}
