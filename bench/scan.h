#pragma once

#include "frame/frame.h"
#include "sim/lidar.h"
#include "sim/scene.h"

namespace hgg {

/// A frame of the simulated yard as a 64-beam, 2048-column LiDAR sees it at `time` (about 100k points), true odometry.
inline Frame simulatedFrame(double time) {
  const Scene scene = makeYard(1);
  LidarModel lidar;
  lidar.beams = 64;
  lidar.columns = 2048;
  lidar.range_max = 80;
  const Pose T_odom_body = scene.T_world_body(0).inverse() * scene.T_world_body(time);
  std::vector<Point> points = scan(scene.world, lidar, beamDirections(lidar), scene.T_world_body(time),
                                   {1, static_cast<std::uint64_t>(time * 10)});
  for (Point& p : points) {
    p.instance = 0;
  }
  return {static_cast<Micros>(time * 1e6), T_odom_body, std::move(points)};
}

}  // namespace hgg
