#pragma once

#include "frame/frame.h"
#include "sim/lidar.h"
#include "sim/scene.h"

namespace hgg {

/// A frame of the simulated yard as a 64-beam, 2048-column LiDAR sees it at `time` (about 100k points), labels and
/// odometry true.
inline Frame simulatedFrame(double time) {
  const Scene scene = makeYard(1);
  LidarModel lidar = spinningLidar(64, false);
  lidar.columns = 2048;
  const RayGrid grid = lidarGrid(lidar);
  RayCaster caster(scene);
  const RandomKey key = keyFor(1, Purpose::kRanges, 0, static_cast<std::uint64_t>(time * 10));
  const Scan scan = measure(caster, scene.world, grid, lidar.errors, scene.T_world_body, {time, 0}, key, 1);
  std::vector<Point> points;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (scan.range[i] > 0 && scan.mixed[i] == 0) {
      const Eigen::Vector3f p = scan.range[i] * grid.directions[i].cast<float>();
      points.push_back({p.x(), p.y(), p.z(), 0, scene.world.objects[static_cast<std::size_t>(scan.object[i])].label});
    }
  }
  const Pose T_odom_body = scene.T_world_body(0).inverse() * scene.T_world_body(time);
  return {static_cast<Micros>(time * 1e6), T_odom_body, std::move(points)};
}

}  // namespace hgg
