#include "sim/lidar.h"

#include <cmath>

#include "core/units.h"

namespace hgg {
namespace {

constexpr double kIndoorRangeMin = 0.3;

}  // namespace

LidarModel spinningLidar(int beams, bool indoor) {
  LidarModel lidar;
  lidar.beams = beams;
  if (beams <= 16) {
    lidar.elevation_min_deg = -15.0, lidar.elevation_max_deg = 15.0;
  } else if (indoor) {
    lidar.elevation_min_deg = -22.5, lidar.elevation_max_deg = 22.5;
  } else if (beams > 64) {
    lidar.elevation_min_deg = -25.0, lidar.elevation_max_deg = 15.0;
  }
  if (indoor) {
    lidar.errors.range_min = kIndoorRangeMin;
  }
  return lidar;
}

LidarModel solidStateLidar(bool indoor) {
  LidarModel lidar;
  lidar.beams = 100, lidar.columns = 480;
  lidar.field_of_view_deg = 120.0;
  lidar.elevation_min_deg = -12.5, lidar.elevation_max_deg = 12.5;
  if (indoor) {
    lidar.errors.range_min = kIndoorRangeMin;
  }
  return lidar;
}

LidarModel preciseSolidStateLidar(bool indoor) {
  LidarModel lidar = solidStateLidar(indoor);
  lidar.beams = 64, lidar.columns = 400;
  lidar.elevation_min_deg = -20.0, lidar.elevation_max_deg = 20.0;
  lidar.errors.noise = 0.008, lidar.errors.range_max = 25.0;
  return lidar;
}

RayGrid lidarGrid(const LidarModel& lidar) {
  RayGrid grid;
  grid.width = lidar.columns, grid.height = lidar.beams;
  grid.wraps = lidar.field_of_view_deg >= 360.0;
  grid.pitch_x_deg = lidar.field_of_view_deg / lidar.columns;
  const double span_deg = lidar.elevation_max_deg - lidar.elevation_min_deg;
  grid.pitch_y_deg = lidar.beams > 1 ? span_deg / (lidar.beams - 1) : 0.0;
  for (int y = 0; y < grid.height; ++y) {
    const double elevation = kDegree * (lidar.beams > 1 ? lidar.elevation_min_deg + y * grid.pitch_y_deg
                                                        : lidar.elevation_min_deg + span_deg / 2);
    for (int x = 0; x < grid.width; ++x) {
      const double azimuth = kDegree * ((x + 0.5) * grid.pitch_x_deg - lidar.field_of_view_deg / 2);
      grid.directions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                   std::sin(elevation));
    }
  }
  return grid;
}

}  // namespace hgg
