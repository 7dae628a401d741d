#pragma once

#include "sim/sensor.h"

namespace hgg {

/// A LiDAR at the origin of the body; its frame is the body frame.
struct LidarModel {
  int beams = 64;
  int columns = 1024;  // firings over the field of view
  double field_of_view_deg = 360.0;
  double elevation_min_deg = -24.8;
  double elevation_max_deg = 2.0;
  RangeErrors errors{.range_min = 1.0,
                     .range_max = 100.0,
                     .noise = 0.02,
                     .dropout = 0.005,
                     .grazing_deg = 3.0,
                     .foliage_depth = 0.5,
                     .mixed = 0.1};
};

/// A spinning LiDAR of 16, 64 or 128 beams. Indoors it looks up as far as down, and near.
LidarModel spinningLidar(int beams, bool indoor);
/// A solid-state LiDAR that looks forward, 120 degrees wide.
LidarModel solidStateLidar(bool indoor);
/// Its better relative: fewer beams, a taller view, 8 mm of range noise, 25 m of range.
LidarModel preciseSolidStateLidar(bool indoor);

/// Columns by azimuth, from the right (-fov/2) to the left; rows by elevation, the lowest first.
RayGrid lidarGrid(const LidarModel& lidar);

}  // namespace hgg
