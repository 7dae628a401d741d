#pragma once

#include <vector>

#include "sim/random.h"
#include "sim/world.h"

namespace hgg {

/// A spinning LiDAR; its frame is the body frame.
struct LidarModel {
  int beams = 32;
  int columns = 1024;  // firings a turn
  double elevation_min_deg = -22.0;
  double elevation_max_deg = 3.0;
  double range_min = 1.0;
  double range_max = 60.0;
  double range_noise = 0.02;  // standard deviation, m
};

/// Unit vectors in the body frame, column by column (azimuth from +x towards +y), lowest beam first.
std::vector<Vec3> beamDirections(const LidarModel& lidar);

/// One turn from a sensor at rest: a point for every beam that hits something in range, labelled, `instance` = object
/// id.
std::vector<Point> scan(const World& world, const LidarModel& lidar, const std::vector<Vec3>& directions_body,
                        const Pose& T_world_body, const RandomKey& noise);

}  // namespace hgg
