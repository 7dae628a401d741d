#include <cmath>

#include "core/units.h"
#include "sim/random.h"
#include "sim/scene.h"
#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

constexpr double kLapTime = 20.0;
constexpr double kHalfLength = 15.0, kHalfWidth = 10.0;  // of the oval the sensor drives
constexpr double kSensorHeight = 1.8;

/// A place beside the oval: `offset` outward from the road's centre line, yaw along the road.
struct Place {
  Vec3 ground;
  double yaw;
};

Place besideRoad(double lap_share, double offset) {
  const double angle = kTau * lap_share;
  const Eigen::Vector2d on_road(kHalfLength * std::cos(angle), kHalfWidth * std::sin(angle));
  const Eigen::Vector2d along =
      Eigen::Vector2d(-kHalfLength * std::sin(angle), kHalfWidth * std::cos(angle)).normalized();
  const Eigen::Vector2d p = on_road + offset * Eigen::Vector2d(along.y(), -along.x());
  return {Vec3(p.x(), p.y(), 0.0), std::atan2(along.y(), along.x())};
}

void addCar(World& world, const Place& at) {
  const Vec3 up(0, 0, 1);
  addObject(world, objectOf(Outdoor::kCar),
            {uprightBox(at.ground + 0.25 * up, Vec3(4.2, 1.8, 0.65), at.yaw),
             uprightBox(at.ground + 0.9 * up, Vec3(2.3, 1.6, 0.6), at.yaw)});
}

void addBicycle(World& world, const Place& at) {
  addObject(world, objectOf(Outdoor::kBicycle),
            {uprightBox(at.ground + Vec3(0, 0, 0.1), Vec3(1.7, 0.35, 0.9), at.yaw)});
}

void addPole(World& world, const Place& at) {
  addObject(world, objectOf(Outdoor::kPole), {Cylinder{at.ground, 0.12, 3.2}});
}

void addSign(World& world, const Place& at) {
  addObject(world, objectOf(Outdoor::kTrafficSign),
            {uprightBox(at.ground + Vec3(0, 0, 1.0), Vec3(0.08, 0.8, 0.8), at.yaw)});
}

void addYardTree(World& world, const Place& at) {
  addObject(world, objectOf(Outdoor::kTrunk), {Cylinder{at.ground, 0.22, 2.2}});
  addObject(world, objectOf(Outdoor::kVegetation), {Cylinder{at.ground + Vec3(0, 0, 2.2), 1.4, 2.5}});
}

void addHouse(World& world, const Place& at, const Vec3& size) {
  addObject(world, objectOf(Outdoor::kBuilding), {uprightBox(at.ground, size, at.yaw)});
}

void addSurroundings(World& world) {
  addObject(world, objectOf(Outdoor::kRoad), {Plane{Vec3::Zero(), Vec3::UnitZ()}});
  addObject(world, objectOf(Outdoor::kTerrain), {uprightBox(Vec3::Zero(), Vec3(18.0, 10.0, 0.05), 0.0)});
  addHouse(world, {Vec3(2.0, 0.5, 0.0), 0.1}, Vec3(6.0, 4.0, 3.5));
  constexpr int kHouses = 5;
  for (int i = 0; i < kHouses; ++i) {
    addHouse(world, besideRoad((i + 0.5) / kHouses, 14.0), Vec3(10.0, 6.0, 5.0));
  }
  addObject(world, objectOf(Outdoor::kFence), {uprightBox(Vec3(0.0, 24.0, 0.0), Vec3(20.0, 0.1, 1.4), 0.0)});
}

}  // namespace

Scene makeYard(std::uint64_t seed) {
  Scene scene;
  scene.T_world_body = [](double time) {
    const double lap_share = time / kLapTime;
    const Place at = besideRoad(lap_share, 0.0);
    Pose pose = Pose::Identity();
    pose.translation() = at.ground + Vec3(0, 0, kSensorHeight + 0.02 * std::sin(kTau * time / 1.3));
    pose.linear() = (Eigen::AngleAxisd(at.yaw, Vec3::UnitZ()) *
                     Eigen::AngleAxisd(0.008 * std::sin(kTau * time / 2.9), Vec3::UnitY()) *
                     Eigen::AngleAxisd(0.006 * std::sin(kTau * time / 3.7), Vec3::UnitX()))
                        .toRotationMatrix();
    return pose;
  };
  scene.duration = 2.0 * kLapTime;
  addSurroundings(scene.world);
  const RandomKey key{seed, 1};
  constexpr int kSlots = 24;
  for (int i = 0; i < kSlots; ++i) {
    const double jitter = uniform(key, static_cast<std::uint64_t>(i)) - 0.5;
    const double lap_share = (i + 0.3 * jitter) / kSlots;
    switch (i % 4) {
      case 0:
      case 2:
        addCar(scene.world, besideRoad(lap_share, 4.5 + 0.6 * jitter));
        break;
      case 1:
        i % 8 == 1 ? addYardTree(scene.world, besideRoad(lap_share, 6.5))
                   : addPole(scene.world, besideRoad(lap_share, 6.0));
        break;
      default:
        i % 8 == 3 ? addBicycle(scene.world, besideRoad(lap_share, 5.0))
                   : addSign(scene.world, besideRoad(lap_share, 5.5));
    }
  }
  constexpr int kInner = 6;
  for (int i = 0; i < kInner; ++i) {
    const Place at = besideRoad((i + 0.5) / kInner, -4.0);
    i % 2 == 0 ? addYardTree(scene.world, at) : addPole(scene.world, at);
  }
  return scene;
}

}  // namespace hgg
