#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/classes.h"
#include "core/units.h"
#include "frame/frame.h"
#include "test_scene.h"

namespace hgg {

/// A street for tests: ground, a wall along it, and boxes that stand or move, seen by a spinning LiDAR without
/// distortion.
struct TrafficBox {
  ClassId label = kCar;
  Vec3 half = {2.1, 0.9, 0.75};
  Vec3 centre = Vec3::Zero();                                // at time 0
  Vec3 velocity = Vec3::Zero();                              // m/s
  double from_s = 0;                                         // moves from then on,
  double until_s = std::numeric_limits<double>::infinity();  // until then

  Vec3 at(double t) const { return centre + std::clamp(t - from_s, 0.0, until_s - from_s) * velocity; }
};

constexpr ClassId kHouse = 50, kWalker = 30;

/// Cars and persons can move.
inline ClassTable trafficClasses() {
  const auto table = ClassTable::parse(R"(
[[class]]
id = 10
name = "car"
kind = "thing"
radius = 0.3
min_points = 10
dynamic = true
[[class]]
id = 30
name = "person"
kind = "thing"
radius = 0.25
min_points = 8
dynamic = true
[[class]]
id = 80
name = "pole"
kind = "thing"
radius = 0.25
min_points = 8
[[class]]
id = 40
name = "road"
kind = "stuff"
min_points = 20
[[class]]
id = 50
name = "building"
kind = "stuff"
min_points = 20
)",
                                       "traffic classes");
  EXPECT_TRUE(table) << table.error;
  return *table;
}

/// Distance along the ray to the box; nothing where it misses.
inline std::optional<double> meets(const Vec3& origin, const Vec3& direction, const Vec3& centre, const Vec3& half) {
  double near = 0, far = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double a = (centre[k] - half[k] - origin[k]) / direction[k];
    const double b = (centre[k] + half[k] - origin[k]) / direction[k];
    near = std::max(near, std::min(a, b)), far = std::min(far, std::max(a, b));
  }
  return near < far && near > 0 ? std::optional(near) : std::nullopt;
}

struct TrafficWorld {
  static constexpr double kBeamSpacingDeg = 0.9;  // from row to row; half of that from column to column

  std::vector<TrafficBox> boxes;
  double wall_y = 14;  // m, left of the way
  int columns = 800;   // of beams

  /// The frame of time t from T_map_body; its ranges are noisy by 2 cm.
  Frame frameAt(double t, const Pose& T_map_body, std::mt19937& random) const {
    constexpr int kRows = 32;
    constexpr double kReach = 60;
    std::normal_distribution<double> noise(0, 0.02);
    Frame frame;
    frame.utime_us = static_cast<Micros>(std::llround(t * 1e6)) + 1'000'000;
    frame.T_odom_body = T_map_body;
    const Vec3 origin = T_map_body.translation();
    for (int n = 0; n < columns * kRows; ++n) {
      const double yaw = kTau * (n % columns) / columns + 1e-4;
      const double pitch = (-24 + kBeamSpacingDeg * static_cast<double>(n / columns)) * kDegree + 1e-5;
      const Vec3 u =
          T_map_body.linear() * Vec3(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch));
      double range = kReach;
      ClassId label = kUnlabeled;
      const auto take = [&](double d, ClassId of) {
        if (d > 0 && d < range) {
          range = d, label = of;
        }
      };
      take(-origin.z() / u.z(), kRoad);
      const double wall = (wall_y - origin.y()) / u.y();
      take((origin + wall * u).z() < 6 ? wall : 0, kHouse);
      for (const TrafficBox& box : boxes) {
        take(meets(origin, u, box.at(t), box.half).value_or(0), box.label);
      }
      if (range < kReach) {
        frame.points.push_back(pointAt(T_map_body.inverse() * (origin + (range + noise(random)) * u), label));
      }
    }
    return frame;
  }
};

}  // namespace hgg
