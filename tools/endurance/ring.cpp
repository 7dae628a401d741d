#include "endurance/ring.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/se3.h"
#include "core/units.h"
#include "sim/lidar.h"
#include "sim/random.h"
#include "sim/raycaster.h"
#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

constexpr double kStretch = 10;        // m of road that are drawn together
constexpr double kSensorHeight = 1.8;  // m
constexpr double kSight = 45;          // m
constexpr int kBeams = 16, kColumns = 180;
constexpr double kLowest = -15 * kDegree, kHighest = 15 * kDegree;
constexpr double kRangeNoise = 0.02;  // m

enum RingPurpose : std::uint64_t { kItems = 1, kRanges = 2, kSteps = 3 };

/// Numbers of one stretch.
class StretchDice {
 public:
  StretchDice(std::uint64_t seed, std::uint64_t stretch) : key_{seed, kItems << 56 | stretch} {}
  double between(double low, double high) { return low + (high - low) * uniform(key_, count_++); }
  bool chance(double share) { return uniform(key_, count_++) < share; }

 private:
  RandomKey key_;
  std::uint64_t count_ = 0;
};

}  // namespace

RingRoad::RingRoad(double length, std::uint64_t seed)
    : length_(length), stretches_(std::max<std::int64_t>(std::llround(length / kStretch), 1)), seed_(seed) {}

Pose RingRoad::T_map_body(double along) const {
  const double radius = length_ / (2 * std::numbers::pi), angle = along / radius;
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = radius * Vec3(std::sin(angle), 1 - std::cos(angle), 0);
  return T;
}

Vec3 RingRoad::beside(double along, double left, double z) const {
  return T_map_body(along) * Vec3(0, left, z - kSensorHeight);
}

std::vector<RingRoad::Item> RingRoad::itemsOf(std::int64_t stretch) const {
  const std::int64_t k = (stretch % stretches_ + stretches_) % stretches_;
  const double start = length_ * static_cast<double>(k) / static_cast<double>(stretches_);
  const double yaw = 2 * std::numbers::pi * (start + kStretch / 2) / length_;
  StretchDice dice(seed_, static_cast<std::uint64_t>(k));
  std::vector<Item> items;
  const auto add = [&](Outdoor label, bool is_thing, const Shape& shape, const Vec3& centre) {
    items.push_back({static_cast<ClassId>(label), is_thing, {shape}, centre});
  };
  const auto slab = [&](Outdoor label, double left, double width, double top) {
    const Vec3 base = beside(start + kStretch / 2, left, top - 0.5);
    add(label, false, uprightBox(base, Vec3(kStretch + 1, width, 0.5), yaw), base);
  };
  slab(Outdoor::kRoad, 0, 9, 0);
  for (const double side : {-1.0, 1.0}) {
    slab(Outdoor::kSidewalk, side * 6, 3, 0.1);
    slab(Outdoor::kTerrain, side * 17.5, 20, 0.05);
    if (dice.chance(0.6)) {
      const double width = dice.between(6, 9), depth = dice.between(6, 10), height = dice.between(4, 9);
      const Vec3 base = beside(start + dice.between(4, 6), side * (dice.between(9, 13) + depth / 2), 0);
      add(Outdoor::kBuilding, false, uprightBox(base, Vec3(width, depth, height), yaw + dice.between(-0.1, 0.1)), base);
    }
    if (dice.chance(0.5)) {
      const Vec3 base = beside(start + dice.between(2, 8), side * dice.between(3.4, 3.8), 0.25);
      const Vec3 size(dice.between(3.6, 4.8), dice.between(1.6, 1.9), dice.between(1.1, 1.5));
      add(Outdoor::kCar, true, uprightBox(base, size, yaw), base + Vec3(0, 0, size.z() / 2));
    }
    for (const auto& [label, share, radius] :
         {std::tuple(Outdoor::kTrunk, 0.4, 0.2), std::tuple(Outdoor::kPole, 0.35, 0.1)}) {
      if (dice.chance(share)) {
        const Vec3 base = beside(start + dice.between(0, 10), side * dice.between(5.5, 7), 0.1);
        const double height = dice.between(2.5, 5);
        add(label, true, Cylinder{base, radius * dice.between(0.8, 1.5), height}, base + Vec3(0, 0, height / 2));
      }
    }
    if (dice.chance(0.2)) {
      const Vec3 base = beside(start + dice.between(0, 10), side * 5, 0.1);
      add(Outdoor::kBin, true, Cylinder{base, 0.3, 1.1}, base + Vec3(0, 0, 0.55));
    }
  }
  return items;
}

World RingRoad::worldAround(double along, double reach) const {
  World world;
  const auto first = static_cast<std::int64_t>(std::floor((along - reach) / kStretch));
  const auto last = static_cast<std::int64_t>(std::ceil((along + reach) / kStretch));
  for (std::int64_t k = first; k <= std::min(last, first + stretches_ - 1); ++k) {
    for (const Item& item : itemsOf(k)) {
      addObject(world, item.label, item.is_thing, item.shapes);
    }
  }
  return world;
}

std::vector<RingRoad::Thing> RingRoad::thingsAround(double along, double reach) const {
  std::vector<Thing> things;
  const Vec3 here = T_map_body(along).translation();
  const auto first = static_cast<std::int64_t>(std::floor((along - reach) / kStretch));
  const auto last = static_cast<std::int64_t>(std::ceil((along + reach) / kStretch));
  for (std::int64_t k = first; k <= std::min(last, first + stretches_ - 1); ++k) {
    for (const Item& item : itemsOf(k)) {
      if (item.is_thing && (item.centre - here).norm() < reach) {
        things.push_back({item.label, item.centre});
      }
    }
  }
  return things;
}

std::vector<Point> scanOf(const World& world, const Pose& T_map_body, std::uint64_t seed) {
  const Scene scene{world, nullptr};
  const RayCaster caster(scene);
  const RandomKey key{seed, kRanges << 56};
  std::vector<Point> points;
  std::uint64_t ray = 0;
  for (int column = 0; column < kColumns; ++column) {
    for (int beam = 0; beam < kBeams; ++beam, ++ray) {
      // Beams turn by a share of a column from scan to scan, as those of a free-running LiDAR.
      const double azimuth =
          2 * std::numbers::pi * (column + uniform(key, 3 * static_cast<std::uint64_t>(kColumns * kBeams))) / kColumns;
      const double elevation = kLowest + (kHighest - kLowest) * beam / (kBeams - 1);
      const Vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                           std::sin(elevation));
      const auto hit = caster.cast({T_map_body.translation(), T_map_body.linear() * direction}, kSight);
      if (hit && hit->range > 1) {
        const Eigen::Vector3f p = ((hit->range + kRangeNoise * gaussian(key, ray)) * direction).cast<float>();
        points.push_back({p.x(), p.y(), p.z(), 0, world.objects[hit->object].label});
      }
    }
  }
  return points;
}

Pose RingOdometry::advance(const Pose& T_last_now) {
  constexpr double kNoise = 0.002, kTurn = 0.01 * kDegree;  // share of the way; rad per sqrt(m)
  const RandomKey key{seed_, kSteps << 56};
  const double way = T_last_now.translation().norm();
  Pose error = Pose::Identity();
  error.translation() = kNoise * way * Vec3(gaussian(key, 4 * step_), gaussian(key, 4 * step_ + 1), 0);
  error.linear() =
      Eigen::AngleAxisd(kTurn * std::sqrt(way) * gaussian(key, 4 * step_ + 2), Vec3::UnitZ()).toRotationMatrix();
  ++step_;
  T_odom_body_ = orthonormalized(T_odom_body_ * T_last_now * error);
  return T_odom_body_;
}

}  // namespace hgg
