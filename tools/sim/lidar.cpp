#include "sim/lidar.h"

#include "sim/raycast.h"

namespace hgg {

std::vector<Vec3> beamDirections(const LidarModel& lidar) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const double span_deg = lidar.elevation_max_deg - lidar.elevation_min_deg;
  std::vector<Vec3> directions;
  directions.reserve(static_cast<std::size_t>(lidar.beams) * static_cast<std::size_t>(lidar.columns));
  for (int column = 0; column < lidar.columns; ++column) {
    const double azimuth = 2.0 * std::numbers::pi * column / lidar.columns;
    for (int beam = 0; beam < lidar.beams; ++beam) {
      const double share = lidar.beams > 1 ? static_cast<double>(beam) / (lidar.beams - 1) : 0.5;
      const double elevation = (lidar.elevation_min_deg + share * span_deg) * kDegree;
      directions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
    }
  }
  return directions;
}

std::vector<Point> scan(const World& world, const LidarModel& lidar, const std::vector<Vec3>& directions_body,
                        const Pose& T_world_body, const RandomKey& noise) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < directions_body.size(); ++i) {
    const Vec3& direction = directions_body[i];
    const auto hit = castRay(world, {T_world_body.translation(), T_world_body.linear() * direction});
    if (!hit || hit->range < lidar.range_min || hit->range > lidar.range_max) {
      continue;
    }
    const Eigen::Vector3f p = ((hit->range + lidar.range_noise * gaussian(noise, i)) * direction).cast<float>();
    const WorldObject& object = world.objects[hit->object];
    points.push_back({p.x(), p.y(), p.z(), object.id, object.label});
  }
  return points;
}

}  // namespace hgg
