#pragma once

#include <filesystem>

#include "progress.h"
#include "sim/lidar.h"
#include "sim/odometry.h"
#include "sim/scene.h"
#include "truth/objects.h"

namespace hgg {

struct SimOptions {
  std::uint64_t seed = 1;
  int frames = 200;
  double rate_hz = 10.0;
  bool instances = false;  // put object ids on the points
  LidarModel lidar;
  OdometryError odometry;
};

/// What is true of a simulated drive. The map frame is the first pose's.
struct DriveTruth {
  std::vector<TruthObject> objects;  // things with at least one point
  std::vector<Pose> T_map_body;
};

/// Drives through the scene and writes the LCM log. The same scene and options give the same bytes.
Result<DriveTruth> simulate(const Scene& scene, const SimOptions& options, const std::filesystem::path& log,
                            const Progress& progress);

}  // namespace hgg
