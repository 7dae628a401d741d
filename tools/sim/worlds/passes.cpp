#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

/// A road along x, gently bent, that is driven out, back on the other lane, and out again; turning places at its ends.
constexpr double kLength = 300.0;
constexpr double kLane = 1.75;                                          // m from the middle of the road
constexpr double kRoad = 5.9, kSidewalk = 8.1;                          // edges, m from the middle
constexpr double kTurningX = 12.0, kTurningRadius = 11.0;               // of the turning places, beyond the ends
constexpr double kBayFrom = 110.0, kBayUntil = 160.0, kBayEdge = 18.0;  // a car park to the left of the way out
constexpr double kBeyond = 55.0, kBeside = 50.0;                        // where the ground ends
constexpr double kSensorHeight = 1.7;
constexpr double kSpeed = 8.2, kTurnRate = 0.8;  // m/s on the straight, rad/s

double height(const Vec2& p) { return 1.2 * std::sin(p.x() / 45.0) + 0.5 * std::sin(p.y() / 23.0 + 0.7); }

/// The middle of the road, and its slope.
double middleY(double x) { return 7.0 * std::sin(std::numbers::pi * std::clamp(x, 0.0, kLength) / 150.0); }
Vec2 alongAt(double x) {
  const bool is_bent = x > 0.0 && x < kLength;
  const double slope = is_bent ? 7.0 * std::numbers::pi / 150.0 * std::cos(std::numbers::pi * x / 150.0) : 0.0;
  return Vec2(1.0, slope).normalized();
}

/// `d` m to the left of the middle, as seen on the way out.
Vec2 beside(double x, double d) {
  const Vec2 along = alongAt(x);
  return Vec2(x, middleY(x)) + d * Vec2(-along.y(), along.x());
}
double leftOf(const Vec2& p) { return (p.y() - middleY(p.x())) * alongAt(p.x()).x(); }

/// Out at -d, around, back at +d, around.
std::vector<Vec2> lap(double d, double turning_radius) {
  constexpr double kStep = 6.0;
  std::vector<Vec2> corners;
  const auto turn = [&](double x, double ahead) {
    for (const double degrees : {-120.0, -75.0, -30.0, 30.0, 75.0, 120.0}) {
      const double angle = degrees * std::numbers::pi / 180.0;
      corners.emplace_back(x + ahead * turning_radius * std::cos(angle), ahead * turning_radius * std::sin(angle));
    }
  };
  for (double x = 0.0; x <= kLength; x += kStep) {
    corners.push_back(beside(x, -d));
  }
  turn(kLength + kTurningX, 1.0);
  for (double x = kLength; x >= 0.0; x -= kStep) {
    corners.push_back(beside(x, d));
  }
  turn(-kTurningX, -1.0);
  return corners;
}

bool onTurningPlace(const Vec2& p) {
  return std::min((p - Vec2(-kTurningX, 0)).norm(), (p - Vec2(kLength + kTurningX, 0)).norm()) < kTurningRadius;
}

Outdoor groundAt(const Vec2& p) {
  const double left = leftOf(p);
  const bool is_along = p.x() > -kTurningX && p.x() < kLength + kTurningX;
  if (p.x() > kBayFrom && p.x() < kBayUntil && left > kRoad && left < kBayEdge) {
    return Outdoor::kParking;
  }
  if (onTurningPlace(p) || (is_along && std::abs(left) < kRoad)) {
    return Outdoor::kRoad;
  }
  return is_along && std::abs(left) < kSidewalk ? Outdoor::kSidewalk : Outdoor::kTerrain;
}

void addGrounds(World& world) {
  constexpr double kCell = 2.5;
  std::map<Outdoor, std::size_t> objects;
  for (const Outdoor label : {Outdoor::kRoad, Outdoor::kSidewalk, Outdoor::kParking, Outdoor::kTerrain}) {
    objects[label] = addObject(world, objectOf(label), {});
  }
  addGround(world, gridLines({-kBeyond, kLength + kBeyond}, kCell), gridLines({-kBeside, kBeside}, kCell), height,
            [&](const Vec2& center) { return std::optional(objects.at(groundAt(center))); });
}

/// When the sensor is at the far end, and when back at the near one: what changes there is out of its sight.
struct Turns {
  double far, near;  // s
};

class Builder {
 public:
  Builder(Stage& stage, const Turns& turns, std::uint64_t seed, double dynamics)
      : stage_(stage), turns_(turns), dice_(seed, 16), dynamics_(dynamics) {}

  void build() {
    addGrounds(stage_.world());
    addCarPark();
    addRareVehicles();
    for (const double side : {-1.0, 1.0}) {
      addHouses(side);
      addParking(side);
      addLamps(side);
      addKerb(side);
      addFronts(side);
    }
    addMovers();
  }

 private:
  Spot spotAt(double x, double d, double turn) const {
    const Vec2 along = alongAt(x);
    return stage_.spot(beside(x, d), std::atan2(along.y(), along.x()) + turn);
  }
  static double towardsRoad(double side) { return -side * std::numbers::pi / 2; }
  /// Of what stands beside the road and looks at those who drive on that side.
  static double towardsTraffic(double side) { return side > 0 ? 0.0 : std::numbers::pi; }

  std::optional<std::size_t> put(Outdoor label, const Shapes& shapes, const Spot& spot, double gap) {
    return stage_.put(objectOf(label), shapes, spot, gap);
  }

  /// Two rows, nose to nose: those behind are half hidden by those in front.
  void addCarPark() {
    for (const double d : {8.6, 14.2}) {
      const double turn = d < 10.0 ? std::numbers::pi / 2 : -std::numbers::pi / 2;
      for (double x = kBayFrom + 2.0; x < kBayUntil - 2.0; x += dice_.between(2.4, 2.7)) {
        park(spotAt(x, d + dice_.between(-0.15, 0.15), turn + dice_.between(-0.03, 0.03)), x, 0.8);
      }
    }
  }

  /// One each.
  void addRareVehicles() {
    put(Outdoor::kBus, busShapes(), spotAt(dice_.between(40.0, 90.0), -4.9, 0.0), 0.5);
    put(Outdoor::kOtherVehicle, caravanShapes(), spotAt(dice_.between(180.0, 230.0), 4.7, std::numbers::pi), 0.5);
    put(Outdoor::kMotorcycle, motorcycleShapes(), spotAt(dice_.between(240.0, 280.0), -5.2, 0.0), 0.4);
  }

  void addHouses(double side) {
    for (double x = -15.0; x < kLength + 15.0; x += dice_.between(11.0, 15.0)) {
      const bool is_behind_bay = side > 0 && x > kBayFrom - 8.0 && x < kBayUntil + 8.0;
      put(Outdoor::kBuilding, houseShapes(dice_, dice_.between(8.0, 11.0), dice_.between(7.0, 10.0)),
          spotAt(x, side * (dice_.between(11.5, 14.0) + (is_behind_bay ? 10.0 : 0.0)), towardsRoad(side)), 1.5);
    }
  }

  /// Rows of cars half a metre to two metres apart, with free stretches.
  void addParking(double side) {
    for (double x = 8.0; x < kLength - 8.0; x += dice_.between(4.9, 6.3)) {
      const bool in_row = std::sin(0.06 * x + 2.0 * side) > -0.3;
      park(spotAt(x, side * (4.75 + dice_.between(-0.1, 0.15)),
                  (side > 0 ? std::numbers::pi : 0.0) + dice_.between(-0.03, 0.03)),
           x, in_row ? 0.85 : 0.1);
    }
  }

  /// A slot is taken or free, and that may change between two passes.
  void park(const Spot& spot, double x, double share_taken) {
    const bool taken = dice_.chance(share_taken), changes = dice_.chance(0.25 * dynamics_), van = dice_.chance(0.08);
    const Shapes shapes = van ? vanShapes(dice_) : carShapes(dice_);
    if (!taken && !changes) {
      return;
    }
    const auto car = put(van ? Outdoor::kTruck : Outdoor::kCar, shapes, spot, 0.35);
    if (car && changes) {
      const double time = x < 0.5 * kLength ? turns_.far : turns_.near;
      taken ? stage_.takeAway(*car, time) : stage_.bring(*car, time);
    }
  }

  void addLamps(double side) {
    for (double x = dice_.between(0.0, 12.0); x < kLength; x += 24.0) {
      put(Outdoor::kPole, lampPostShapes(dice_.between(5.0, 7.0)), spotAt(x, side * 6.5, towardsRoad(side)), 0.6);
    }
  }

  void addKerb(double side) {
    constexpr double kGap = 0.8;
    for (double x = 2.0; x < kLength; x += dice_.between(3.0, 5.0)) {
      const double kind = dice_.between(0.0, 1.0), d = side * dice_.between(6.4, 6.9);
      if (kind < 0.30) {
        putTree(stage_, treeShapes(dice_), spotAt(x, d, 0.0), kGap);
      } else if (kind < 0.58) {
        putPlate(stage_, dice_, spotAt(x, d, towardsTraffic(side)), kGap);
      } else if (kind < 0.66) {
        put(Outdoor::kPole, poleShapes(dice_.between(1.0, 4.0)), spotAt(x, d, 0.0), kGap);
      } else if (kind < 0.73) {
        put(Outdoor::kBin, binShapes(dice_), spotAt(x, d, 0.0), kGap);
      } else if (kind < 0.80) {
        put(Outdoor::kBicycle, bicycleShapes(), spotAt(x, d, 0.0), kGap);
      } else if (kind < 0.84) {
        put(Outdoor::kBench, benchShapes(1.7), spotAt(x, d, -towardsRoad(side)), kGap);
      } else if (kind < 0.89) {
        put(Outdoor::kPerson, personShapes(dice_, 0.0), spotAt(x, d, dice_.between(0.0, 6.0)), kGap);
      }
    }
  }

  /// Where sidewalk meets garden.
  void addFronts(double side) {
    for (double x = 4.0; x < kLength; x += dice_.between(6.0, 10.0)) {
      const double kind = dice_.between(0.0, 1.0), length = dice_.between(3.0, 5.5), d = side * 8.8;
      if (kind < 0.35) {
        put(Outdoor::kFence, fenceShapes(length), spotAt(x, d, towardsRoad(side)), 0.5);
      } else if (kind < 0.65) {
        put(Outdoor::kVegetation, hedgeShapes(length, dice_.between(0.9, 1.7)), spotAt(x, d, towardsRoad(side)), 0.5);
      } else if (kind < 0.8) {
        put(Outdoor::kVegetation, bushShapes(dice_.between(0.5, 0.9)), spotAt(x, d, 0.0), 0.5);
      }
    }
  }

  /// Cars on the sensor's own way, before it and against it; people on the sidewalks.
  void addMovers() {
    const auto count = [&](double most) { return static_cast<int>(std::lround(most * dynamics_)); };
    const Journey road({lap(kLane, 0.6 * kTurningRadius), 12.0}, kSpeed, kTurnRate);
    for (int i = 0; i < count(5); ++i) {
      const double ahead = i == 0 ? 45.0 : (0.1 + 0.16 * i) * road.way().length();
      stage_.send(objectOf(Outdoor::kCar), carShapes(dice_), road, ahead + dice_.between(-5.0, 5.0));
    }
    for (int i = 0; i < count(8); ++i) {
      std::vector<Vec2> corners = lap(7.4, kTurningRadius + 2.0);
      if (i % 2 == 1) {
        std::ranges::reverse(corners);
      }
      stage_.send(objectOf(Outdoor::kPerson), personShapes(dice_, 1.0),
                  Journey({corners, 3.0}, dice_.between(1.1, 1.5), 1.5), dice_.between(0.0, 640.0));
    }
  }

  Stage& stage_;
  Turns turns_;
  Dice dice_;
  double dynamics_;
};

}  // namespace

Scene makePasses(std::uint64_t seed, double dynamics) {
  const Journey travel({lap(kLane, 0.6 * kTurningRadius), 12.0}, kSpeed, kTurnRate);
  const double turn = 0.25 * (travel.way().length() - 2.0 * kLength);  // m from the end of a pass to the turn's middle
  Scene scene;
  scene.T_world_body = bodyOn(travel, height, {.height = kSensorHeight, .sway = 0.008, .bob = 0.02});
  scene.duration = travel.lapTime() + travel.timeAt(kLength - 2.0);
  Stage stage(scene, height, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 1.5);
  const Turns turns{travel.timeAt(kLength + turn), travel.timeAt(travel.way().length() - turn)};
  Builder(stage, turns, seed, dynamics).build();
  return scene;
}

}  // namespace hgg
