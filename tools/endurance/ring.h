#pragma once

#include <cstdint>
#include <vector>

#include "core/types.h"
#include "frame/frame.h"
#include "sim/world.h"

namespace hgg {

/// A road that closes, of any length: houses, parked cars, trees, lamp posts and signs on both sides, drawn anew from
/// the seed for each ten metres of it, so that nothing of it is kept. Metres along it from its start; the frame is that
/// of the start: x ahead, y left, z up from the sensor.
class RingRoad {
 public:
  RingRoad(double length, std::uint64_t seed);

  double length() const { return length_; }
  Pose T_map_body(double along) const;
  /// What stands within `reach` (m) of a place on the road, along it.
  World worldAround(double along, double reach) const;
  /// The middles of the things among it, with their classes.
  struct Thing {
    ClassId label = 0;
    Vec3 p_map = Vec3::Zero();
  };
  std::vector<Thing> thingsAround(double along, double reach) const;

 private:
  struct Item {
    ClassId label = 0;
    bool is_thing = false;
    std::vector<Shape> shapes;
    Vec3 centre;
  };
  /// What stands in one stretch of the road.
  std::vector<Item> itemsOf(std::int64_t stretch) const;
  Vec3 beside(double along, double left, double z) const;

  double length_;
  std::int64_t stretches_;
  std::uint64_t seed_;
};

/// A thinned scan of a 16-beam LiDAR from a place on the road; label errors aside, as a robot would send it.
std::vector<Point> scanOf(const World& world, const Pose& T_map_body, std::uint64_t seed);

/// Odometry along the road, one step after the other: 0.2 % of the way and 0.01 degrees per square root of a metre off.
class RingOdometry {
 public:
  explicit RingOdometry(std::uint64_t seed) : seed_(seed) {}
  Pose advance(const Pose& T_last_now);

 private:
  std::uint64_t seed_, step_ = 0;
  Pose T_odom_body_ = Pose::Identity();
};

}  // namespace hgg
