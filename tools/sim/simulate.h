#pragma once

#include <filesystem>
#include <optional>

#include "progress.h"
#include "sim/camera.h"
#include "sim/kidnap.h"
#include "sim/labels.h"
#include "sim/lidar.h"
#include "sim/odometry.h"
#include "sim/odometry_faults.h"
#include "sim/scene.h"
#include "truth/objects.h"
#include "truth/walk_grid.h"

namespace hgg {

/// What the body carries. A LiDAR alone and a depth camera alone label their own points; with cameras beside it the
/// LiDAR's points get their labels from the images.
struct SensorSuite {
  std::optional<LidarModel> lidar;
  std::vector<SimCamera> cameras;
};

struct SimOptions {
  std::uint64_t seed = 1;  // of the noise; the scene has its own
  int frames = 0;          // 0: the scene's whole tour
  double rate_hz = 10.0;
  int every = 1;  // every Nth frame is written, with its odometry and its truth; the others might as well not be
  SensorSuite sensors;
  LabelErrors cloud_labels, image_labels;
  std::optional<OdometryErrors> odometry;  // nullopt: the scene's own poses where it has some, else the truth
  OdometryFaults odometry_faults;          // on every channel of odometry
  CarriedOdometry carried_odometry = CarriedOdometry::kGoesOn;
  bool instances = false;          // put object ids on points and pixels of things
  bool motion_distortion = false;  // the LiDAR sweeps during the time before the frame's
  double gait_deg = 0;             // the body rolls and pitches as it walks
  bool semantic_cloud = true;      // with cameras: LIDAR_SEMANTIC too, as a mapper would make it from the rest
  bool perfect_transfer = false;   // of that cloud: each return a camera sees has what the segmenter says of its object
  bool walk_grid = true;           // the truth of where one can walk, see WalkGrid
  int threads = 1;
};

/// What is true of a simulated drive. The map frame is the first pose's.
struct DriveTruth {
  std::vector<TruthObject> objects;  // things with at least one point
  std::vector<Pose> T_map_body;      // one a frame of the log
  std::vector<Pose> T_world_body;    // the same in the scene's frame
  double end_time = 0;               // s, the last frame's
  std::optional<WalkGrid> walk_grid;
};

/// Drives through the scene and writes the LCM log (as <log>.part until it is whole), and <log stem>.rig.toml beside it
/// where there are cameras. The same scene and options give the same bytes, whatever the number of threads.
Result<DriveTruth> simulate(const Scene& scene, const SimOptions& options, const std::filesystem::path& log,
                            const Progress& progress);

/// The drive's truth with the reference cloud and the queries of the scene.
WorldTruth completeTruth(const Scene& scene, const DriveTruth& drive, int threads);

/// The scene's trajectory on legs: roll and pitch of about `gait_deg` and some bob, at 1.6 strides a second.
Trajectory withGait(Trajectory T_world_body, double gait_deg);

int frameCount(const Scene& scene, const SimOptions& options);

}  // namespace hgg
