#include "sim/options.h"

#include "truth/poses.h"

namespace hgg {
namespace {

constexpr double kGait_deg = 1.5;
constexpr int kRigCameras = 3;

std::optional<SensorSuite> suiteOf(const std::string& name, int cameras, bool indoor) {
  if (name == "lidar16") {
    return SensorSuite{spinningLidar(16, indoor), {}};
  }
  if (name == "lidar64") {
    return SensorSuite{spinningLidar(64, indoor), {}};
  }
  if (name == "lidar128") {
    return SensorSuite{spinningLidar(128, indoor), {}};
  }
  if (name == "solid") {
    return SensorSuite{solidStateLidar(indoor), {}};
  }
  if (name == "solid64") {
    return SensorSuite{preciseSolidStateLidar(indoor), {}};
  }
  if (name == "rgbd") {
    return SensorSuite{std::nullopt, {depthCamera()}};
  }
  if (name == "rig") {
    return SensorSuite{spinningLidar(64, indoor), rigCameras(cameras)};
  }
  return std::nullopt;
}

void overrideLabels(LabelErrors& errors, const SimArguments& arguments, Segmented what) {
  errors.speckle = arguments.speckle.value_or(errors.speckle);
  errors.unknown = arguments.unknown.value_or(errors.unknown);
  errors.bleed = arguments.bleed.value_or(errors.bleed);
  errors.confused = arguments.confusion.value_or(errors.confused);
  errors.missed = arguments.missed.value_or(errors.missed);
  errors.common = arguments.confusion_common;
  // A rate on top of perfect labels takes its extent from good ones.
  const LabelErrors good = *labelPreset("good", what);
  if (errors.bleed_deg == 0) {
    errors.bleed_deg = good.bleed_deg;
  }
  if (errors.stretch_frames == 1) {
    errors.stretch_frames = good.stretch_frames;
  }
}

void overrideRanges(RangeErrors& errors, const SimArguments& arguments) {
  errors.noise = arguments.range_noise.value_or(errors.noise);
  if (arguments.range_noise) {
    errors.noise_per_m2 = 0;
  }
  errors.dropout = arguments.dropout.value_or(errors.dropout);
}

Result<std::optional<OdometryErrors>> odometryErrors(const SimArguments& arguments, const Scene& scene) {
  using Errors = Result<std::optional<OdometryErrors>>;
  const bool disturbed = arguments.odometry_dropout > 0 || arguments.odometry_jumps > 0;
  if (!arguments.odometry && scene.T_odom_body && !disturbed) {
    return Errors::ok(std::nullopt);
  }
  if (!arguments.odometry && scene.T_odom_body) {
    return Errors::fail("--path brings its own odometry: give --odometry PRESET to disturb the true poses instead");
  }
  auto errors = odometryPreset(arguments.odometry.value_or("good"));
  if (!errors) {
    std::string names;
    for (const std::string& name : odometryPresetNames()) {
      names += " " + name;
    }
    return Errors::fail("--odometry " + *arguments.odometry + ": try one of" + names);
  }
  errors->dropout = arguments.odometry_dropout;
  errors->jumps_per_100m = arguments.odometry_jumps;
  return Errors::ok(errors);
}

/// An error line, empty when done.
std::string addFaults(const SimArguments& arguments, const Scene& scene, SimOptions& options) {
  for (const std::string& text : arguments.odometry_faults) {
    if (text == "xyzw") {
      options.odometry_faults.quaternion_xyzw = true;
      continue;
    }
    const auto fault = parseFault(text);
    if (!fault) {
      return "--odometry-fault " + fault.error + "; or xyzw";
    }
    if (fault->time > (frameCount(scene, options) - 1) / options.rate_hz) {
      return "--odometry-fault " + text + ": the drive is over by then";
    }
    options.odometry_faults.timed.push_back(*fault);
  }
  options.carried_odometry = arguments.kidnap_odometry == "zero"   ? CarriedOdometry::kRestarts
                             : arguments.kidnap_odometry == "true" ? CarriedOdometry::kFollows
                                                                   : CarriedOdometry::kGoesOn;
  return "";
}

/// What was asked for and would do nothing; empty when there is nothing of the kind.
std::string unusedArgument(const SimArguments& arguments, const SensorSuite& sensors, const Scene& scene) {
  const SimOptions& options = arguments.options;
  if (arguments.plates && (!arguments.path.empty() || !hasPlates(arguments.world))) {
    return "--plates is for street and campus (passes has them anyway)";
  }
  if (arguments.cameras && arguments.sensor != "rig") {
    return "--cameras needs --sensor rig";
  }
  if (options.perfect_transfer && (sensors.cameras.empty() || !sensors.lidar)) {
    return "--perfect-transfer needs a LiDAR and cameras (--sensor rig)";
  }
  if (!options.semantic_cloud && sensors.cameras.empty()) {
    return "--no-semantic needs cameras (--sensor rgbd or rig): without them there is no other cloud";
  }
  if (options.motion_distortion && !sensors.lidar) {
    return "--motion-distortion needs a LiDAR: cameras take all at once";
  }
  if (arguments.kidnap_odometry != "on" && !arguments.kidnap) {
    return "--kidnap-odometry needs --kidnap";
  }
  if (options.odometry_faults.bursts_stay && options.odometry_faults.bursts == 0) {
    return "--bursts-stay needs --odometry-bursts";
  }
  if (scene.carried && (frameCount(scene, options) - 1) / options.rate_hz < scene.carried->until) {
    return "--kidnap: the drive is over before the robot is put down again";
  }
  SimOptions whole = options;
  whole.frames = 0;
  if (!arguments.path.empty() && options.frames > frameCount(scene, whole)) {
    return "--frames " + std::to_string(options.frames) + ": the poses of --path are enough for " +
           std::to_string(frameCount(scene, whole));
  }
  return "";
}

}  // namespace

std::vector<SensorName> sensorNames() {
  return {{"lidar16", "spinning LiDAR, 16 x 1024"},
          {"lidar64", "spinning LiDAR, 64 x 1024"},
          {"lidar128", "spinning LiDAR, 128 x 1024"},
          {"solid", "solid-state LiDAR, 120 degrees wide, 100 x 480"},
          {"solid64", "solid-state LiDAR, 120 degrees wide, 64 x 400, 8 mm of range noise, 25 m"},
          {"rgbd", "depth camera with a label image, 320 x 240"},
          {"rig", "spinning LiDAR, 64 x 1024, labelled through 1..3 cameras (--cameras)"}};
}

namespace {

Result<Scene> undisturbedScene(const SimArguments& arguments) {
  const std::uint64_t seed = arguments.options.seed;
  if (arguments.path.empty()) {
    auto scene = makeScene(arguments.world, seed, arguments.dynamics, arguments.plates);
    return scene ? Result<Scene>::ok(std::move(*scene))
                 : Result<Scene>::fail("there is no world \"" + arguments.world + "\": hgg-sim --list names them");
  }
  const auto truth = readPoses(arguments.path[0]);
  if (!truth) {
    return Result<Scene>::fail(truth.error);
  }
  const auto odometry = readPoses(arguments.path[1]);
  if (!odometry) {
    return Result<Scene>::fail(odometry.error);
  }
  if (truth->size() != odometry->size() || truth->size() < 2) {
    return Result<Scene>::fail("--path needs two files with the same number of poses, at least 2: " +
                               std::to_string(truth->size()) + " and " + std::to_string(odometry->size()));
  }
  return Result<Scene>::ok(pathScene(*truth, *odometry, seed, arguments.dynamics));
}

}  // namespace

Result<Scene> sceneOf(const SimArguments& arguments) {
  auto scene = undisturbedScene(arguments);
  if (!scene || !arguments.kidnap) {
    return scene;
  }
  const auto kidnap = parseKidnap(*arguments.kidnap);
  return kidnap ? kidnapped(std::move(*scene), *kidnap, arguments.options.rate_hz, arguments.options.seed)
                : Result<Scene>::fail("--kidnap " + kidnap.error);
}

Result<SimOptions> simOptions(const SimArguments& arguments, const Scene& scene) {
  using Options = Result<SimOptions>;
  SimOptions options = arguments.options;
  options.seed = arguments.noise_seed.value_or(options.seed);
  const auto suite = suiteOf(arguments.sensor, arguments.cameras.value_or(kRigCameras), scene.label_space == "indoor");
  if (!suite) {
    return Options::fail("there is no sensor \"" + arguments.sensor + "\": hgg-sim --list names them");
  }
  const std::string unused = unusedArgument(arguments, *suite, scene);
  if (!unused.empty()) {
    return Options::fail(unused);
  }
  options.sensors = *suite;
  if (options.sensors.lidar) {
    overrideRanges(options.sensors.lidar->errors, arguments);
  }
  for (SimCamera& camera : options.sensors.cameras) {
    if (camera.depth) {
      overrideRanges(camera.errors, arguments);
    }
  }
  const auto cloud_labels = labelPreset(arguments.labels, Segmented::kCloud);
  const auto image_labels = labelPreset(arguments.labels, Segmented::kImage);
  if (!cloud_labels || !image_labels) {
    return Options::fail("--labels " + arguments.labels + ": try perfect, good or poor");
  }
  options.cloud_labels = *cloud_labels, options.image_labels = *image_labels;
  overrideLabels(options.cloud_labels, arguments, Segmented::kCloud);
  overrideLabels(options.image_labels, arguments, Segmented::kImage);
  const auto odometry = odometryErrors(arguments, scene);
  if (!odometry) {
    return Options::fail(odometry.error);
  }
  options.odometry = *odometry;
  if (const std::string error = addFaults(arguments, scene, options); !error.empty()) {
    return Options::fail(error);
  }
  options.gait_deg = arguments.gait ? kGait_deg : 0.0;
  return Options::ok(options);
}

}  // namespace hgg
