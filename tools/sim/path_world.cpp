#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "frame/camera.h"
#include "sim/scene.h"
#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

constexpr double kRate_hz = 10.0;                               // of the poses
constexpr double kCameraHeight = 1.65;                          // m above the road, KITTI's
constexpr double kStep = 0.5;                                   // m between the samples of the track
constexpr double kRoad = 4.2, kSidewalk = 6.8, kGround = 30.0;  // m from the track to the ground's edges
constexpr double kSamePlace = 9.0;  // m: a place the track has passed before is already furnished

/// Camera axes to body axes, for poses of both.
Pose bodyOfCamera(const Pose& T_world_camera) {
  const Mat3 R_body_camera = cameraAxes();
  Pose T = Pose::Identity();
  T.linear() = R_body_camera * T_world_camera.linear() * R_body_camera.transpose();
  T.translation() = R_body_camera * T_world_camera.translation();
  return T;
}

Pose between(const Pose& a, const Pose& b, double share) {
  Pose T = Pose::Identity();
  T.translation() = (1.0 - share) * a.translation() + share * b.translation();
  T.linear() = Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix();
  return T;
}

std::function<Pose(double)> interpolate(const std::vector<Pose>& T_world_camera) {
  std::vector<Pose> poses;
  std::ranges::transform(T_world_camera, std::back_inserter(poses), bodyOfCamera);
  return [poses = std::move(poses)](double time) {
    const double index = std::clamp(time * kRate_hz, 0.0, static_cast<double>(poses.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(index), poses.size() - 1);
    return between(poses[i], poses[std::min(i + 1, poses.size() - 1)], index - static_cast<double>(i));
  };
}

/// Points that are looked up by place.
class PointGrid {
 public:
  void add(const Vec2& p, std::size_t index) { cells_[cellOf(p)].push_back(index); }
  template <typename Visit>
  void near(const Vec2& p, double reach, Visit&& visit) const {
    const auto lo = cellOf(p - Vec2(reach, reach)), hi = cellOf(p + Vec2(reach, reach));
    for (auto x = lo.first; x <= hi.first; ++x) {
      for (auto cell = cells_.lower_bound({x, lo.second});
           cell != cells_.end() && cell->first <= std::pair(x, hi.second); ++cell) {
        std::ranges::for_each(cell->second, visit);
      }
    }
  }

 private:
  static std::pair<int, int> cellOf(const Vec2& p) {
    constexpr double kCell = 5.0;
    return {static_cast<int>(std::floor(p.x() / kCell)), static_cast<int>(std::floor(p.y() / kCell))};
  }
  std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
};

/// The way that was driven, as evenly spaced samples on the road.
class Track {
 public:
  Track(const std::function<Pose(double)>& T_world_body, double duration) {
    Vec3 last = T_world_body(0.0).translation();
    append(last, 0.0);
    for (double time = 0.0; time < duration; time += 1.0 / (10.0 * kRate_hz)) {
      const Vec3 p = T_world_body(time).translation();
      if ((p - last).head<2>().norm() >= kStep) {
        append(p, time);
        last = p;
      }
    }
  }

  std::size_t size() const { return points_.size(); }
  const std::vector<Vec2>& points() const { return points_; }
  double timeAt(std::size_t i) const { return times_[i]; }

  /// Direction of travel, over a few metres.
  Vec2 along(std::size_t i) const {
    constexpr std::size_t kReach = 6;
    const Vec2 d = points_[std::min(i + kReach, size() - 1)] - points_[i < kReach ? 0 : i - kReach];
    return d.norm() > 0.0 ? Vec2(d.normalized()) : Vec2::UnitX();
  }

  /// m to the nearest sample, no more than `reach`.
  double distance(const Vec2& p, double reach) const {
    double nearest = reach;
    grid_.near(p, reach, [&](std::size_t i) { nearest = std::min(nearest, (points_[i] - p).norm()); });
    return nearest;
  }

  /// The road's height, smoothed over passes that disagree and carried on beside the road.
  double groundHeight(const Vec2& p) const {
    constexpr double kBlend = 9.0;  // m^2: samples this near count alike
    for (double reach = 12.0;; reach *= 2.0) {
      double sum = 0.0, mass = 0.0;
      grid_.near(p, reach, [&](std::size_t i) {
        const double weight = std::pow((points_[i] - p).squaredNorm() + kBlend, -2.0);
        sum += weight * ground_[i];
        mass += weight;
      });
      if (mass > 0.0) {
        return sum / mass;
      }
    }
  }

  /// Sample `i` is where the track has been before, or comes to the side of an earlier stretch.
  bool wasPassedBefore(std::size_t i) const {
    constexpr std::size_t kEarlier = 80;  // samples
    bool passed = false;
    grid_.near(points_[i], kSamePlace, [&](std::size_t k) {
      passed = passed || (k + kEarlier < i && (points_[k] - points_[i]).norm() < kSamePlace);
    });
    return passed;
  }

  /// When the track comes back to within `reach` m of p, at least `gap` s after it first was; the middle of that
  /// absence.
  double absence(const Vec2& p, double reach, double gap) const {
    std::vector<double> times;
    grid_.near(p, reach, [&](std::size_t i) {
      if ((points_[i] - p).norm() < reach) {
        times.push_back(times_[i]);
      }
    });
    std::ranges::sort(times);
    for (std::size_t i = 1; i < times.size(); ++i) {
      if (times[i] - times[i - 1] > gap) {
        return 0.5 * (times[i] + times[i - 1]);
      }
    }
    return 0.0;
  }

 private:
  void append(const Vec3& p, double time) {
    grid_.add(p.head<2>(), points_.size());
    points_.emplace_back(p.head<2>());
    ground_.push_back(p.z() - kCameraHeight);
    times_.push_back(time);
  }

  std::vector<Vec2> points_;
  std::vector<double> ground_, times_;
  PointGrid grid_;
};

void addGrounds(World& world, const Track& track) {
  constexpr double kCell = 2.5;
  Vec2 lo = track.points().front(), hi = lo;
  for (const Vec2& p : track.points()) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  const std::size_t road = addObject(world, objectOf(Outdoor::kRoad), {});
  const std::size_t sidewalk = addObject(world, objectOf(Outdoor::kSidewalk), {});
  const std::size_t terrain = addObject(world, objectOf(Outdoor::kTerrain), {});
  addGround(
      world, gridLines({lo.x() - kGround, hi.x() + kGround}, kCell),
      gridLines({lo.y() - kGround, hi.y() + kGround}, kCell), [&](const Vec2& p) { return track.groundHeight(p); },
      [&](const Vec2& center) -> std::optional<std::size_t> {
        const double apart = track.distance(center, kGround);
        if (apart >= kGround) {
          return std::nullopt;
        }
        return apart < kRoad ? road : apart < kSidewalk ? sidewalk : terrain;
      });
}

/// Furnishes both sides of the track, each place once.
class Builder {
 public:
  Builder(Stage& stage, const Track& track, std::uint64_t seed, double dynamics)
      : stage_(stage), track_(track), dice_(seed, 3), dynamics_(dynamics) {}

  void build() {
    addGrounds(stage_.world(), track_);
    for (const double side : {-1.0, 1.0}) {
      along(11.0, 15.0, [&](std::size_t i) { addHouse(i, side); });
    }
    addRareVehicles();
    for (const double side : {-1.0, 1.0}) {
      along(5.4, 7.0, [&](std::size_t i) { addParkedCar(i, side); });
      along(20.0, 26.0, [&](std::size_t i) {
        put(Outdoor::kPole, lampPostShapes(dice_.between(5.0, 7.5)), beside(i, side * 6.4, towardsRoad(side)), 0.8);
      });
      along(4.0, 8.0, [&](std::size_t i) { addKerbThing(i, side); });
      along(5.0, 10.0, [&](std::size_t i) { addFront(i, side); });
    }
  }

 private:
  /// Visits new places of the track, `lo`..`hi` m apart.
  template <typename Visit>
  void along(double lo, double hi, Visit&& visit) {
    for (double s = dice_.between(0.0, hi); s < kStep * static_cast<double>(track_.size());
         s += dice_.between(lo, hi)) {
      const auto i = static_cast<std::size_t>(s / kStep);
      if (!track_.wasPassedBefore(i)) {
        visit(i);
      }
    }
  }

  /// `d` m to the left of the track (negative: right), turned from its direction.
  Spot beside(std::size_t i, double d, double turn) const {
    const Vec2 along = track_.along(i);
    return stage_.spot(track_.points()[i] + d * Vec2(-along.y(), along.x()), std::atan2(along.y(), along.x()) + turn);
  }
  static double towardsRoad(double side) { return -side * std::numbers::pi / 2; }

  std::optional<std::size_t> put(Outdoor label, const Shapes& shapes, const Spot& spot, double gap) {
    return stage_.put(objectOf(label), shapes, spot, gap);
  }

  /// One each, early on the way, so that a short drive meets them.
  void addRareVehicles() {
    constexpr double kWithin = 300.0;  // m
    const auto somewhere = [&] {
      return static_cast<std::size_t>(
          dice_.between(0.0, std::min(0.9 * kStep * static_cast<double>(track_.size()), kWithin)) / kStep);
    };
    constexpr int kTries = 20;
    const auto putOnce = [&](Outdoor label, const Shapes& shapes, double d) {
      for (int i = 0; i < kTries && !put(label, shapes, beside(somewhere(), d, 0.0), 0.6); ++i) {
      }
    };
    putOnce(Outdoor::kBus, busShapes(), -4.9);
    putOnce(Outdoor::kOtherVehicle, caravanShapes(), -4.8);
    putOnce(Outdoor::kMotorcycle, motorcycleShapes(), -5.4);
  }

  void addHouse(std::size_t i, double side) {
    if (dice_.chance(0.85)) {
      put(Outdoor::kBuilding, houseShapes(dice_, dice_.between(8.0, 12.5), dice_.between(7.0, 11.0)),
          beside(i, side * dice_.between(11.5, 16.0), towardsRoad(side)), 1.5);
    }
  }

  /// Rows of cars with stretches of free kerb between them.
  void addParkedCar(std::size_t i, double side) {
    const bool in_row = std::sin(0.045 * kStep * static_cast<double>(i) + side) > -0.2;
    const bool taken = dice_.chance(in_row ? 0.8 : 0.08), changes = dice_.chance(0.4 * dynamics_);
    const bool van = dice_.chance(0.1);
    const Shapes shapes = van ? vanShapes(dice_) : carShapes(dice_);
    const Spot spot = beside(i, side * (4.6 + dice_.between(-0.1, 0.2)), side > 0 ? std::numbers::pi : 0.0);
    const double absence = changes ? track_.absence(spot.ground.head<2>(), 20.0, 30.0) : 0.0;
    if (!taken && absence == 0.0) {
      return;
    }
    const auto car = put(van ? Outdoor::kTruck : Outdoor::kCar, shapes, spot, 0.6);
    if (car && absence > 0.0) {
      taken ? stage_.takeAway(*car, absence) : stage_.bring(*car, absence);
    }
  }

  void addKerbThing(std::size_t i, double side) {
    constexpr double kGap = 0.9;
    const double kind = dice_.between(0.0, 1.0), d = side * dice_.between(6.2, 6.9);
    if (kind < 0.35) {
      putTree(stage_, treeShapes(dice_), beside(i, d, 0.0), kGap);
    } else if (kind < 0.5) {
      put(Outdoor::kTrafficSign, signShapes(dice_), beside(i, d, side > 0 ? 0.0 : std::numbers::pi), kGap);
    } else if (kind < 0.6) {
      put(Outdoor::kPole, poleShapes(dice_.between(1.0, 4.5)), beside(i, d, 0.0), kGap);
    } else if (kind < 0.7) {
      put(Outdoor::kBicycle, bicycleShapes(), beside(i, d, 0.0), kGap);
    } else if (kind < 0.76) {
      put(Outdoor::kBin, binShapes(dice_), beside(i, d, 0.0), kGap);
    } else if (kind < 0.8) {
      put(Outdoor::kBench, benchShapes(1.7), beside(i, d, -towardsRoad(side)), kGap);
    } else if (kind < 0.85) {
      put(Outdoor::kPerson, personShapes(dice_, 0.0), beside(i, d, dice_.between(-std::numbers::pi, std::numbers::pi)),
          kGap);
    }
  }

  /// Where sidewalk meets garden.
  void addFront(std::size_t i, double side) {
    const double kind = dice_.between(0.0, 1.0), length = dice_.between(3.0, 6.0), d = side * dice_.between(8.2, 9.2);
    if (kind < 0.35) {
      put(Outdoor::kFence, fenceShapes(length), beside(i, d, towardsRoad(side)), 0.5);
    } else if (kind < 0.65) {
      put(Outdoor::kVegetation, hedgeShapes(length, dice_.between(0.9, 1.8)), beside(i, d, towardsRoad(side)), 0.5);
    } else if (kind < 0.85) {
      put(Outdoor::kVegetation, bushShapes(dice_.between(0.5, 1.0)), beside(i, d, 0.0), 0.5);
    }
  }

  Stage& stage_;
  const Track& track_;
  Dice dice_;
  double dynamics_;
};

/// A car that comes towards the sensor in the other lane; gone at the track's start.
struct Oncoming {
  double start;  // m along the track at time 0
  double speed;

  std::optional<Pose> pose(const Track& track, double time) const {
    constexpr double kOtherLane = 3.0;  // m to the left
    const double s = (start - speed * time) / kStep;
    if (s < 0.0 || s >= static_cast<double>(track.size() - 1)) {
      return std::nullopt;
    }
    const auto i = static_cast<std::size_t>(s);
    const double share = s - static_cast<double>(i);
    const Vec2 ahead = ((1.0 - share) * track.along(i) + share * track.along(i + 1)).normalized();
    const Vec2 p =
        (1.0 - share) * track.points()[i] + share * track.points()[i + 1] + kOtherLane * Vec2(-ahead.y(), ahead.x());
    return poseOf({Vec3(p.x(), p.y(), track.groundHeight(p)), std::atan2(-ahead.y(), -ahead.x())});
  }
};

/// Never so near to the sensor that they would touch: the track crosses itself and turns back.
bool keepsClear(const Oncoming& car, const Track& track, const Scene& scene) {
  constexpr double kTouch = 2.4;
  for (double time = 0.0; time < scene.duration; time += 0.2) {
    const auto pose = car.pose(track, time);
    if (pose && (pose->translation() - scene.T_world_body(time).translation()).head<2>().norm() < kTouch) {
      return false;
    }
  }
  return true;
}

void addTraffic(Scene& scene, const std::shared_ptr<const Track>& track, std::uint64_t seed, double dynamics) {
  constexpr double kApart = 150.0;  // m between two cars
  Dice dice(seed, 4);
  const double length = kStep * static_cast<double>(track->size());
  for (double s = 60.0; s < 2.0 * length; s += dice.between(0.5, 1.5) * kApart / std::max(dynamics, 1e-3)) {
    const Oncoming car{s, dice.between(6.0, 10.0)};
    const Shapes shapes = carShapes(dice);
    if (!keepsClear(car, *track, scene)) {
      continue;
    }
    WorldObject object = objectOf(Outdoor::kCar);
    object.dynamic = true;
    // Its shapes are added at the world's origin, from where the motion carries them.
    const std::size_t index = addObject(scene.world, object, shapes);
    scene.motions.push_back({index, [car, track](double time) { return car.pose(*track, time); }});
  }
}

}  // namespace

Scene pathScene(const std::vector<Pose>& T_world_camera, const std::vector<Pose>& T_odom_camera, std::uint64_t seed,
                double dynamics) {
  Scene scene;
  scene.T_world_body = interpolate(T_world_camera);
  scene.T_odom_body = interpolate(T_odom_camera);
  scene.duration = static_cast<double>(T_world_camera.size() - 1) / kRate_hz;
  const auto track = std::make_shared<const Track>(scene.T_world_body, scene.duration);
  Stage stage(
      scene, [track](const Vec2& p) { return track->groundHeight(p); }, scene.duration);
  stage.layout().keepOff(track->points(), 2.4);
  Builder(stage, *track, seed, dynamics).build();
  if (dynamics > 0.0) {
    addTraffic(scene, track, seed, dynamics);
  }
  return scene;
}

}  // namespace hgg
