#include "sim/simulate.h"

#include <cmath>

#include "frame_log.h"

namespace hgg {
namespace {

constexpr Micros kStart_us = 1'000'000;
/// Streams of randomness: below this the odometry steps, from here on the scans.
constexpr std::uint64_t kScanStream = std::uint64_t{1} << 32;

double frameTime(const SimOptions& options, std::size_t frame) { return static_cast<double>(frame) / options.rate_hz; }

std::vector<Pose> drive(const Scene& scene, const SimOptions& options) {
  const Pose T_map_world = scene.T_world_body(0.0).inverse();
  std::vector<Pose> poses{Pose::Identity()};
  for (std::size_t i = 1; i < static_cast<std::size_t>(options.frames); ++i) {
    poses.push_back(T_map_world * scene.T_world_body(frameTime(options, i)));
  }
  return poses;
}

void accumulate(TruthAccumulator& truth, const World& world, std::size_t frame, const std::vector<Point>& points,
                const Pose& T_map_body) {
  for (const Point& p : points) {
    const WorldObject& object = world.objects[p.instance - 1];
    if (object.thing) {
      truth.add(object.id, object.label, frame, T_map_body * Vec3(p.x, p.y, p.z));
    }
  }
}

}  // namespace

Result<DriveTruth> simulate(const Scene& scene, const SimOptions& options, const std::filesystem::path& log,
                            const Progress& progress) {
  auto writer = LogWriter::create(log.string());
  if (!writer) {
    return Result<DriveTruth>::fail(writer.error);
  }
  const std::vector<Pose> T_map_body = drive(scene, options);
  const std::vector<Pose> odometry = disturbOdometry(T_map_body, options.odometry, options.seed);
  const std::vector<Vec3> directions = beamDirections(options.lidar);
  TruthAccumulator truth;
  for (std::size_t i = 0; i < T_map_body.size(); ++i) {
    const double time = frameTime(options, i);
    auto points =
        scan(scene.world, options.lidar, directions, scene.T_world_body(time), {options.seed, kScanStream + i});
    accumulate(truth, scene.world, i, points, T_map_body[i]);
    for (Point& p : points) {
      p.instance = options.instances ? p.instance : 0;
    }
    const std::string error = writeFrame(*writer, kStart_us + std::llround(time * 1e6), odometry[i], points);
    if (!error.empty()) {
      return Result<DriveTruth>::fail(error);
    }
    progress(i + 1, T_map_body.size());
  }
  const std::string error = writer->close();
  return error.empty() ? Result<DriveTruth>::ok({truth.objects(), T_map_body}) : Result<DriveTruth>::fail(error);
}

}  // namespace hgg
