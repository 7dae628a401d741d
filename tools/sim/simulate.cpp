#include "sim/simulate.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <system_error>

#include "bus/codec.h"
#include "bus/log.h"
#include "class_tables.h"
#include "core/units.h"
#include "sim/motion.h"
#include "sim/queries.h"
#include "sim/walk_truth.h"
#include "sim/world_cloud.h"

namespace hgg {
namespace {

constexpr Micros kStart_us = 1'000'000;

/// Points with what only a simulator knows of them; body frame.
struct TrueCloud {
  std::vector<Point> points;
  std::vector<float> times;           // s after the frame's time; empty: all at it
  std::vector<std::int32_t> objects;  // index into World::objects; -1: between surfaces, on none
};

/// A camera at work.
struct Eye {
  const SimCamera* model;
  RayGrid grid;
  Scan scan;
  LabelImage labels;
  DepthImage depth;
};

/// All that stays the same from frame to frame.
struct Drive {
  const Scene& scene;
  const SimOptions& options;
  Trajectory T_world_body;
  std::vector<double> times;      // of all frames
  std::vector<std::size_t> kept;  // those in the log
  RayGrid lidar;
  std::vector<Eye> eyes;
  Segmentation cloud_segmentation, image_segmentation;
  std::vector<std::vector<Mistake>> cloud_mistakes, image_mistakes;  // by frame; empty: none
  std::optional<WalkTruth> walk;

  double sweep() const { return options.motion_distortion ? 1.0 / options.rate_hz : 0.0; }
};

/// Places of what can be seen, world frame, about a metre apart.
std::vector<CloudPoint> seenSurface(const Drive& drive) {
  constexpr double kApart = 1.0;
  std::vector<Pose> T_world_body;
  for (const std::size_t frame : drive.kept) {
    T_world_body.push_back(drive.T_world_body(drive.times[frame]));
  }
  auto surface = sampleSurfaces(drive.scene, T_world_body, drive.times[drive.kept.back()],
                                {.spacing = kApart, .threads = drive.options.threads});
  const Eigen::Isometry3f T_world_map = T_world_body.front().cast<float>();
  for (CloudPoint& p : surface) {
    const Eigen::Vector3f p_world = T_world_map * Eigen::Vector3f(p.x, p.y, p.z);
    p.x = p_world.x(), p.y = p_world.y(), p.z = p_world.z();
  }
  return surface;
}

void addMistakes(Drive& drive) {
  const SimOptions& options = drive.options;
  if (options.cloud_labels.common <= 0 && options.image_labels.common <= 0) {
    return;
  }
  const std::vector<CloudPoint> surface = seenSurface(drive);
  const auto mistakes = [&](double share) {
    return commonMistakes(drive.scene.world, surface, share, options.seed, drive.times.size());
  };
  drive.cloud_mistakes = mistakes(options.cloud_labels.common);
  drive.image_mistakes = mistakes(options.image_labels.common);
}

/// The mistakes of a frame as its segmenter makes them; whole objects get their wrong name in `object_labels`.
FrameMistakes mistakesAt(const Drive& drive, const std::vector<std::vector<Mistake>>& by_frame, std::size_t frame,
                         const RayGrid& grid, const Exposure& exposure, std::vector<ClassId>& object_labels) {
  FrameMistakes mistakes;
  if (by_frame.empty()) {
    return mistakes;
  }
  mistakes.patches = nameWholeObjects(by_frame[frame], object_labels);
  for (int x = 0; x < (exposure.sweep > 0 ? grid.width : 1); ++x) {
    const double time = exposure.sweep > 0 ? columnTime(grid, exposure, x) : exposure.time;
    mistakes.T_world_sensor.push_back(drive.T_world_body(time) * grid.T_body_sensor);
  }
  return mistakes;
}

Drive makeDrive(const Scene& scene, const SimOptions& options) {
  Drive drive{scene, options, withGait(scene.T_world_body, options.gait_deg), {}, {}, {}, {}, {}, {}, {}, {}, {}};
  for (int i = 0; i < frameCount(scene, options); ++i) {
    const double time = i / options.rate_hz;
    drive.times.push_back(time);
    const bool is_carried = scene.carried && time > scene.carried->from && time < scene.carried->until;
    if (i % options.every == 0 && !is_carried) {
      drive.kept.push_back(static_cast<std::size_t>(i));
    }
  }
  if (options.sensors.lidar) {
    drive.lidar = lidarGrid(*options.sensors.lidar);
  }
  for (const SimCamera& camera : options.sensors.cameras) {
    drive.eyes.push_back({&camera, cameraGrid(camera), {}, {}, {}});
  }
  const auto palette = worldLabels(scene.world);
  drive.cloud_segmentation = {&scene.world, options.cloud_labels, palette, options.instances};
  drive.image_segmentation = {&scene.world, options.image_labels, palette, options.instances};
  addMistakes(drive);
  return drive;
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): a false alarm of clang-tidy 14

std::vector<Pose> fromStart(const Trajectory& T_world_body, const std::vector<double>& times) {
  const Pose T_map_world = T_world_body(times.front()).inverse();
  std::vector<Pose> poses{Pose::Identity()};
  for (std::size_t i = 1; i < times.size(); ++i) {
    poses.push_back(T_map_world * T_world_body(times[i]));
  }
  return poses;
}

/// The odometry of the frames that are kept: true motion with `errors`; without, the scene's own where it has some.
std::vector<Pose> odometryOf(const Drive& drive, const std::vector<Pose>& T_map_body,
                             const std::optional<OdometryErrors>& errors) {
  const SimOptions& options = drive.options;
  const auto& carried = drive.scene.carried;
  std::vector<Pose> odometry;
  if (errors || !drive.scene.T_odom_body) {
    odometry = withoutCarry(T_map_body, drive.times, carried);
    odometry = errors ? disturbOdometry(odometry, *errors, options.seed) : odometry;
  } else {
    odometry =
        withoutCarry(fromStart(withGait(drive.scene.T_odom_body, options.gait_deg), drive.times), drive.times, carried);
  }
  if (options.carried_odometry == CarriedOdometry::kFollows) {
    odometry = withCarry(odometry, T_map_body, drive.times, carried);
  }
  OdometryFaults faults = options.odometry_faults;
  if (carried && options.carried_odometry == CarriedOdometry::kRestarts) {
    faults.timed.push_back({FaultKind::kRestart, carried->until, std::nullopt});
  }
  return withFaults(odometry, options.rate_hz, drive.kept, faults, options.seed);
}

// ---------------------------------------------------------------------------------------------------- sensing

/// Tells the truth of where one can walk which surfaces the beams met.
void countReturns(Drive& drive, const RayGrid& grid, const Scan& scan, const Exposure& exposure) {
  Pose T_world_sensor = drive.T_world_body(exposure.time) * grid.T_body_sensor;
  for (int x = 0; drive.walk && x < grid.width; ++x) {
    if (exposure.sweep > 0) {
      T_world_sensor = drive.T_world_body(columnTime(grid, exposure, x)) * grid.T_body_sensor;
    }
    for (int y = 0; y < grid.height; ++y) {
      const std::size_t i = grid.at(x, y);
      if (scan.range[i] > 0 && !scan.mixed[i]) {
        countReturn(*drive.walk, T_world_sensor * Vec3(static_cast<double>(scan.true_range[i]) * grid.directions[i]),
                    static_cast<std::size_t>(scan.object[i]));
      }
    }
  }
}

void look(Eye& eye, std::size_t camera, Drive& drive, RayCaster& caster, std::size_t frame, Micros utime_us) {
  const SimOptions& options = drive.options;
  const World& world = drive.scene.world;
  eye.scan = measure(caster, world, eye.grid, eye.model->errors, drive.T_world_body, {drive.times[frame], 0.0},
                     keyFor(options.seed, Purpose::kRanges, camera + 1, frame), options.threads);
  std::vector<ClassId> names = objectLabels(world, options.image_labels, options.seed, frame);
  const FrameMistakes mistakes =
      mistakesAt(drive, drive.image_mistakes, frame, eye.grid, {drive.times[frame], 0.0}, names);
  eye.labels = segment(drive.image_segmentation, eye.grid, eye.scan, names,
                       keyFor(options.seed, Purpose::kPixelLabels, camera + 1, frame), options.threads, mistakes);
  eye.labels.utime_us = utime_us;
  if (!eye.model->depth) {
    return;
  }
  eye.depth = depthImage(eye.grid, eye.scan, utime_us);
  countReturns(drive, eye.grid, eye.scan, {drive.times[frame], 0.0});
  // A depth between two surfaces keeps its pixel's label, but is on no object: the truth counts no such points.
  for (std::size_t i = 0; i < eye.labels.instances.size(); ++i) {
    if (eye.scan.mixed[i]) {
      eye.labels.instances[i] = 0;
    }
  }
}

/// The LiDAR's returns, unlabelled.
TrueCloud returnsOf(const RayGrid& grid, const Scan& scan, const Exposure& exposure) {
  TrueCloud cloud;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t i = grid.at(x, y);
      if (scan.range[i] <= 0) {
        continue;
      }
      const Eigen::Vector3f p = (static_cast<double>(scan.range[i]) * grid.directions[i]).cast<float>();
      cloud.points.push_back({p.x(), p.y(), p.z(), 0, 0});
      cloud.objects.push_back(scan.mixed[i] ? -1 : scan.object[i]);
      if (exposure.sweep > 0) {
        cloud.times.push_back(static_cast<float>(columnTime(grid, exposure, x) - exposure.time));
      }
    }
  }
  return cloud;
}

/// Labels the LiDAR's returns as a segmenter of clouds does.
void labelCloud(TrueCloud& cloud, const Drive& drive, const Scan& scan, std::size_t frame) {
  const SimOptions& options = drive.options;
  const RandomKey key = keyFor(options.seed, Purpose::kPixelLabels, 0, frame);
  std::vector<ClassId> names = objectLabels(drive.scene.world, options.cloud_labels, options.seed, frame);
  const FrameMistakes mistakes =
      mistakesAt(drive, drive.cloud_mistakes, frame, drive.lidar, {drive.times[frame], drive.sweep()}, names);
  const LabelImage labels = segment(drive.cloud_segmentation, drive.lidar, scan, names, key, options.threads, mistakes);
  std::size_t n = 0;
  for (std::size_t i = 0; i < scan.range.size(); ++i) {
    if (scan.range[i] <= 0) {
      continue;
    }
    Point& p = cloud.points[n++];
    if (scan.mixed[i] && uniform(key, 4 * scan.range.size() + i) >= options.cloud_labels.mixed) {
      continue;
    }
    p.label = labels.labels[i];
    if (options.instances) {
      p.instance = labels.instances[i];
    }
  }
}

/// For each pixel the nearest return around it, m; infinite where there is none. Returns behind it may be hidden from
/// the camera and would get the label of what hides them.
std::vector<float> nearestReturns(const SimCamera& camera, const TrueCloud& returns) {
  constexpr int kReach = 3;  // pixels: the gaps between beams
  const int width = camera.model.width, height = camera.model.height;
  std::vector<float> nearest(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                             std::numeric_limits<float>::infinity());
  for (const Point& p : returns.points) {
    const Vec3 p_body(p.x, p.y, p.z);
    const auto pixel = project(camera, p_body);
    if (!pixel) {
      continue;
    }
    const auto range = static_cast<float>((p_body - camera.T_body_camera.translation()).norm());
    for (int y = std::max(pixel->y - kReach, 0); y <= std::min(pixel->y + kReach, height - 1); ++y) {
      for (int x = std::max(pixel->x - kReach, 0); x <= std::min(pixel->x + kReach, width - 1); ++x) {
        float& at =
            nearest[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        at = std::min(at, range);
      }
    }
  }
  return nearest;
}

/// The index of the pixel that shows a point; nullopt when something nearer may hide it.
std::optional<std::size_t> visiblePixel(const Eye& eye, const std::vector<float>& nearest, const Point& p) {
  constexpr double kStep = 0.3, kSlope = 0.05;  // m, and per m: surfaces seen at a slant are not hidden by themselves
  const Vec3 p_body(p.x, p.y, p.z);
  const auto pixel = project(*eye.model, p_body);
  if (!pixel) {
    return std::nullopt;
  }
  const std::size_t at = eye.labels.at(pixel->x, pixel->y);
  const double range = (p_body - eye.model->T_body_camera.translation()).norm();
  return range < (1.0 + kSlope) * static_cast<double>(nearest[at]) + kStep ? std::optional(at) : std::nullopt;
}

/// Labels the LiDAR's returns through the cameras; those no camera sees for certain are left out.
TrueCloud labelThroughCameras(const TrueCloud& returns, const std::vector<Eye>& eyes) {
  std::vector<std::vector<float>> nearest;
  for (const Eye& eye : eyes) {
    nearest.push_back(nearestReturns(*eye.model, returns));
  }
  TrueCloud cloud;
  for (std::size_t i = 0; i < returns.points.size(); ++i) {
    Point p = returns.points[i];
    for (std::size_t e = 0; e < eyes.size(); ++e) {
      const auto pixel = visiblePixel(eyes[e], nearest[e], p);
      if (!pixel) {
        continue;
      }
      p.label = eyes[e].labels.labels[*pixel];
      p.instance = eyes[e].labels.instances.empty() ? 0 : eyes[e].labels.instances[*pixel];
      cloud.points.push_back(p);
      cloud.objects.push_back(returns.objects[i]);
      if (!returns.times.empty()) {
        cloud.times.push_back(returns.times[i]);
      }
      break;
    }
  }
  return cloud;
}

/// Whether the camera sees an object at the pixel of a point, or beside it.
bool seesObject(const Eye& eye, const Point& p, std::int32_t object) {
  const auto pixel = project(*eye.model, Vec3(p.x, p.y, p.z));
  for (int k = 0; pixel && k < 9; ++k) {
    const int x = pixel->x + k % 3 - 1, y = pixel->y + k / 3 - 1;
    if (x >= 0 && y >= 0 && x < eye.grid.width && y < eye.grid.height && eye.scan.object[eye.grid.at(x, y)] == object) {
      return true;
    }
  }
  return false;
}

/// All of the LiDAR's returns; those on an object that a camera sees there get what the segmenter of images says of the
/// object, the others 0.
TrueCloud labelPerfectly(TrueCloud returns, const Drive& drive, std::size_t frame) {
  const std::vector<ClassId> names =
      objectLabels(drive.scene.world, drive.options.image_labels, drive.options.seed, frame);
  for (std::size_t i = 0; i < returns.points.size(); ++i) {
    Point& p = returns.points[i];
    const std::int32_t object = returns.objects[i];
    const auto sees = [&](const Eye& eye) { return seesObject(eye, p, object); };
    if (object >= 0 && std::ranges::any_of(drive.eyes, sees)) {
      p.label = names[static_cast<std::size_t>(object)];
    }
  }
  return returns;
}

/// The points of a depth camera with the labels of their pixels.
TrueCloud pointsOf(const Eye& eye) {
  TrueCloud cloud;
  for (int y = 0; y < eye.grid.height; ++y) {
    for (int x = 0; x < eye.grid.width; ++x) {
      const std::size_t i = eye.grid.at(x, y);
      if (eye.depth.depth_mm[i] == 0) {
        continue;
      }
      const Eigen::Vector3f p = unproject(*eye.model, {x, y}, eye.depth.depth_mm[i] / 1000.0).cast<float>();
      cloud.points.push_back(
          {p.x(), p.y(), p.z(), eye.labels.instances.empty() ? 0 : eye.labels.instances[i], eye.labels.labels[i]});
      cloud.objects.push_back(eye.scan.mixed[i] ? -1 : eye.scan.object[i]);
    }
  }
  return cloud;
}

/// What one frame gives.
struct Sensed {
  TrueCloud lidar;     // unlabelled, of a rig
  TrueCloud semantic;  // labelled
};

Sensed sense(Drive& drive, RayCaster& caster, std::size_t frame, Micros utime_us) {
  const SimOptions& options = drive.options;
  for (std::size_t i = 0; i < drive.eyes.size(); ++i) {
    look(drive.eyes[i], i, drive, caster, frame, utime_us);
  }
  Sensed sensed;
  if (!options.sensors.lidar) {
    if (!drive.eyes.empty() && drive.eyes.front().model->depth) {
      sensed.semantic = pointsOf(drive.eyes.front());
    }
    return sensed;
  }
  const Exposure exposure{drive.times[frame], drive.sweep()};
  const Scan scan = measure(caster, drive.scene.world, drive.lidar, options.sensors.lidar->errors, drive.T_world_body,
                            exposure, keyFor(options.seed, Purpose::kRanges, 0, frame), options.threads);
  countReturns(drive, drive.lidar, scan, exposure);
  TrueCloud returns = returnsOf(drive.lidar, scan, exposure);
  if (drive.eyes.empty()) {
    labelCloud(returns, drive, scan, frame);
    sensed.semantic = std::move(returns);
  } else {
    sensed.semantic =
        options.perfect_transfer ? labelPerfectly(returns, drive, frame) : labelThroughCameras(returns, drive.eyes);
    sensed.lidar = std::move(returns);
  }
  return sensed;
}

// ---------------------------------------------------------------------------------------------------- truth and log

void accumulate(TruthAccumulator& truth, const Drive& drive, std::size_t frame, const TrueCloud& cloud,
                const Pose& T_map_world) {
  const Pose T_map_body = T_map_world * drive.T_world_body(drive.times[frame]);
  float time = 0;
  Pose T_map_point = T_map_body;  // where the body was when the point was measured
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.objects[i] < 0) {
      continue;
    }
    const WorldObject& object = drive.scene.world.objects[static_cast<std::size_t>(cloud.objects[i])];
    if (!object.thing) {
      continue;
    }
    if (!cloud.times.empty() && cloud.times[i] != time) {
      time = cloud.times[i];
      T_map_point = T_map_world * drive.T_world_body(drive.times[frame] + static_cast<double>(time));
    }
    const Point& p = cloud.points[i];
    truth.add(object.id, object.label, frame, T_map_point * Vec3(p.x, p.y, p.z));
  }
}

std::string writeImages(LogWriter& log, const std::vector<Eye>& eyes, Micros utime_us) {
  std::string error;
  for (const Eye& eye : eyes) {
    const std::string& name = eye.model->name;
    if (eye.model->depth && error.empty()) {
      error = log.write("DEPTH_" + name, utime_us, encodeDepthImage(eye.depth));
    }
    if (error.empty()) {
      error = log.write("CAMERA_LABELS_" + name, utime_us, encodeLabelImage(eye.labels));
    }
  }
  return error;
}

std::string writeClouds(LogWriter& log, const Drive& drive, const Sensed& sensed, Micros utime_us) {
  const bool is_rig = !drive.eyes.empty();
  std::string error;
  if (is_rig && drive.options.sensors.lidar) {
    error = log.write("LIDAR", utime_us, encodeCloud(utime_us, sensed.lidar.points, sensed.lidar.times));
  }
  if (error.empty() && (!is_rig || drive.options.semantic_cloud)) {
    error = log.write("LIDAR_SEMANTIC", utime_us,
                      encodeSemanticCloud(utime_us, sensed.semantic.points, sensed.semantic.times));
  }
  return error;
}

/// The same drive under every preset, so that one log compares them.
std::map<std::string, std::vector<Pose>> everyOdometry(const Drive& drive, const std::vector<Pose>& T_map_body) {
  std::map<std::string, std::vector<Pose>> tracks;
  for (const std::string& preset : odometryTrackNames()) {
    std::string channel = "POSE_ODOM_" + preset;
    std::ranges::transform(channel, channel.begin(), [](unsigned char c) { return std::toupper(c); });
    tracks[channel] = odometryOf(drive, T_map_body, odometryPreset(preset));
  }
  return tracks;
}

bool isOdometryMissing(const Drive& drive, std::size_t frame) {
  const SimOptions& options = drive.options;
  return options.odometry && isOdometryMissing(*options.odometry, options.seed, frame, drive.kept.back() + 1);
}

std::string writeRigBeside(const std::filesystem::path& log, const SensorSuite& sensors) {
  if (sensors.cameras.empty()) {
    return "";
  }
  return writeRig(sensors.cameras, sensors.lidar.has_value(),
                  (log.parent_path() / (log.stem().string() + ".rig.toml")).string());
}

/// Writes the log of the drive, and fills `result`. Returns an error line, empty when done.
std::string driveThrough(const Scene& scene, const SimOptions& options, const std::filesystem::path& log,
                         const Progress& progress, DriveTruth& result) {
  auto writer = LogWriter::create(log.string());
  if (!writer) {
    return writer.error;
  }
  Drive drive = makeDrive(scene, options);
  const std::vector<Pose> T_map_body = fromStart(drive.T_world_body, drive.times);
  for (const std::size_t frame : drive.kept) {
    result.T_world_body.push_back(drive.T_world_body(drive.times[frame]));
    result.T_map_body.push_back(T_map_body[frame]);
  }
  const std::vector<Pose> odometry = odometryOf(drive, T_map_body, options.odometry);
  const auto tracks = everyOdometry(drive, T_map_body);
  const Pose T_map_world = result.T_world_body.front().inverse();
  RayCaster caster(scene);
  if (options.walk_grid) {
    drive.walk = walkTruth(scene, result.T_world_body, drive.times[drive.kept.back()],
                           {.limits = {}, .threads = options.threads});
  }
  TruthAccumulator truth;
  std::string error;
  for (std::size_t i = 0; i < drive.kept.size() && error.empty(); ++i) {
    const std::size_t frame = drive.kept[i];
    const Micros utime_us = kStart_us + std::llround(drive.times[frame] * 1e6);
    const Sensed sensed = sense(drive, caster, frame, utime_us);
    accumulate(truth, drive, frame, sensed.semantic, T_map_world);
    if (!isOdometryMissing(drive, frame)) {
      error = writer->write("POSE_ODOM", utime_us, encodePose(utime_us, odometry[i]));
    }
    for (const auto& [channel, track] : tracks) {
      if (error.empty()) {
        error = writer->write(channel, utime_us, encodePose(utime_us, track[i]));
      }
    }
    if (error.empty()) {
      error = writeImages(*writer, drive.eyes, utime_us);
    }
    if (error.empty()) {
      error = writeClouds(*writer, drive, sensed, utime_us);
    }
    progress(i + 1, drive.kept.size());
  }
  if (error.empty()) {
    error = writer->close();
  }
  result.objects = truth.objects();
  result.end_time = drive.times[drive.kept.back()];
  markMotion(result.objects, scene, result.end_time);
  if (drive.walk) {
    result.walk_grid = finishedGrid(std::move(*drive.walk));
  }
  return error;
}

/// Where a log is written until it is whole, so that none that was broken off has its name. Pipes and the like have no
/// such place.
std::filesystem::path unfinished(const std::filesystem::path& log) {
  std::error_code none;
  const bool is_special = exists(log, none) && !is_regular_file(log, none);
  return is_special ? log : std::filesystem::path(log.string() + ".part");
}

}  // namespace

Result<DriveTruth> simulate(const Scene& scene, const SimOptions& options, const std::filesystem::path& log,
                            const Progress& progress) {
  using Truth = Result<DriveTruth>;
  const std::filesystem::path part = unfinished(log);
  DriveTruth result;
  std::string error = driveThrough(scene, options, part, progress, result);
  if (error.empty()) {
    error = writeRigBeside(log, options.sensors);
  }
  std::error_code problem;
  if (!error.empty()) {
    if (part != log) {
      remove(part, problem);
    }
    return Truth::fail(error);
  }
  if (part != log) {
    rename(part, log, problem);
  }
  return problem ? Truth::fail("cannot create " + log.string() + ": " + problem.message())
                 : Truth::ok(std::move(result));
}

WorldTruth completeTruth(const Scene& scene, const DriveTruth& drive, int threads) {
  return {drive.objects,
          drive.T_map_body,
          sampleSurfaces(scene, drive.T_world_body, drive.end_time, {.threads = threads}),
          makeQueries(scene, drive.objects),
          scene.label_space == "indoor" ? kIndoorClassesToml : kSemanticKittiClassesToml,
          drive.walk_grid,
          {drive.T_world_body.front(), scene.rooms}};
}

Trajectory withGait(Trajectory T_world_body, double gait_deg) {
  if (gait_deg == 0) {
    return T_world_body;
  }
  return [T_world_body = std::move(T_world_body), gait_deg](double time) {
    constexpr double kStrides = 1.6, kBobPerDegree = 0.01;  // Hz, m
    const double amplitude = gait_deg * kDegree, phase = kTau * kStrides * time;
    Pose sway = Pose::Identity();
    sway.translation().z() = kBobPerDegree * gait_deg * std::sin(2.0 * phase);
    sway.linear() = (Eigen::AngleAxisd(0.7 * amplitude * std::sin(2.0 * phase + 1.0), Vec3::UnitY()) *
                     Eigen::AngleAxisd(amplitude * std::sin(phase), Vec3::UnitX()))
                        .toRotationMatrix();
    return T_world_body(time) * sway;
  };
}

int frameCount(const Scene& scene, const SimOptions& options) {
  return options.frames > 0 ? options.frames : 1 + static_cast<int>(scene.duration * options.rate_hz);
}

}  // namespace hgg
