#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/simulate.h"

namespace hgg {

/// What a user asks of hgg-sim, in words.
struct SimArguments {
  std::string world;                        // a name of sceneNames(), or empty and:
  std::vector<std::string> path;            // files of true and odometry poses (KITTI, camera frame)
  double dynamics = 0;                      // 0..1
  bool plates = false;                      // small signs on poles
  std::optional<std::uint64_t> noise_seed;  // of labels, ranges and odometry; default: the world's, options.seed
  std::string sensor = "lidar64";           // of sensorNames()
  std::optional<int> cameras;               // of a rig; default 3
  std::string labels = "good";              // of labelPreset()
  std::optional<double> speckle, unknown, bleed, confusion, missed;  // override the preset
  double confusion_common = 0;                                       // LabelErrors::common
  std::optional<double> range_noise, dropout;                        // override the sensor's
  std::optional<std::string> odometry;  // of odometryPreset(); default: the path's own, else good
  double odometry_dropout = 0, odometry_jumps = 0;
  std::vector<std::string> odometry_faults;  // "xyzw", else of parseFault()
  std::optional<std::string> kidnap;         // of parseKidnap()
  std::string kidnap_odometry = "on";        // or "zero" or "true"
  bool gait = false;
  SimOptions options;  // the rest; completed by simOptions()
};

/// Names and what they stand for.
struct SensorName {
  std::string name, description;
};
std::vector<SensorName> sensorNames();

/// Errors name the argument and what it may be.
Result<Scene> sceneOf(const SimArguments& arguments);
Result<SimOptions> simOptions(const SimArguments& arguments, const Scene& scene);

}  // namespace hgg
