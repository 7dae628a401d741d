#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

/// The sensor walks around a lawn with these half sides; paths cross the lawn and lead out between the halls.
constexpr double kHalfX = 14.5, kHalfY = 7.5;
constexpr double kPath = 1.8;    // half width
constexpr double kPlaza = 12.0;  // where the halls' fronts begin, m outside the way
constexpr double kForecourt = 9.0;
constexpr double kOuter = 60.0;
constexpr double kSensorHeight = 0.7;
constexpr double kLaps = 2.05;

double height(const Vec2& p) { return 0.5 * std::sin(p.x() / 17.0) + 0.35 * std::sin(p.y() / 13.0 + 1.0); }

/// m outside (negative: inside) the rectangle that is walked.
double outside(const Vec2& p) { return std::max(std::abs(p.x()) - kHalfX, std::abs(p.y()) - kHalfY); }

Outdoor groundAt(const Vec2& p) {
  const double d = outside(p);
  const bool on_cross = std::abs(p.x()) < kPath || std::abs(p.y()) < kPath;
  return std::abs(d) < kPath || on_cross || (d > kForecourt && d < kPlaza) ? Outdoor::kSidewalk : Outdoor::kTerrain;
}

std::vector<double> stopsOf(double half) {
  std::vector<double> stops{-kOuter, -kPath, kPath, kOuter};
  for (const double d : {-kPath, kPath, kForecourt, kPlaza}) {
    stops.insert(stops.end(), {half + d, -half - d});
  }
  std::ranges::sort(stops);
  return stops;
}

void addGrounds(World& world) {
  constexpr double kWidest = 3.0;
  const std::size_t path = addObject(world, objectOf(Outdoor::kSidewalk), {});
  const std::size_t lawn = addObject(world, objectOf(Outdoor::kTerrain), {});
  addGround(world, gridLines(stopsOf(kHalfX), kWidest), gridLines(stopsOf(kHalfY), kWidest), height,
            [&](const Vec2& center) { return std::optional(groundAt(center) == Outdoor::kSidewalk ? path : lawn); });
}

std::vector<Vec2> ring(double d) {
  const double x = kHalfX + d, y = kHalfY + d;
  return {Vec2(0, -y), Vec2(x, -y), Vec2(x, y), Vec2(-x, y), Vec2(-x, -y)};
}

class Builder {
 public:
  Builder(Stage& stage, const Way& way, std::uint64_t seed, double dynamics)
      : stage_(stage), way_(way), dice_(seed, 2), dynamics_(dynamics) {}

  /// Small signs on poles beside the way, last of all and by dice of their own: what stands there stays.
  void addPlates(Dice dice) {
    for (double s = dice.between(0.0, 6.0); s < way_.length(); s += dice.between(5.0, 8.0)) {
      const double d = (dice.chance(0.5) ? 1.0 : -1.0) * (kPath + dice.between(0.5, 1.5));
      putPlate(stage_, dice, beside(s, d, dice.chance(0.5) ? 0.0 : std::numbers::pi / 2), 0.5);
    }
  }

  void build() {
    addGrounds(stage_.world());
    addHalls();
    addBicycleRacks();
    addRareVehicles();
    addLamps();
    addSeats();
    scatter();
    addPeople();
  }

 private:
  /// A spot beside the way, `d` m to its right (outside); `turn` 0 faces the way from outside.
  Spot beside(double s, double d, double turn) const {
    const WayPoint at = way_.at(s);
    const Vec2 right(at.along.y(), -at.along.x());
    return stage_.spot(at.position + d * right,
                       std::atan2(-right.y(), -right.x()) + (d < 0 ? std::numbers::pi : 0.0) + turn);
  }

  std::optional<std::size_t> put(Outdoor label, const Shapes& shapes, const Spot& spot, double gap) {
    return stage_.put(objectOf(label), shapes, spot, gap);
  }

  void addHalls() {
    for (const double side : {-1.0, 1.0}) {
      for (const double x : {-17.0, 17.0}) {
        const double width = dice_.between(22.0, 28.0), depth = dice_.between(9.0, 13.0);
        put(Outdoor::kBuilding, houseShapes(dice_, width, depth),
            stage_.spot(Vec2(x, side * (kHalfY + kPlaza)), -side * std::numbers::pi / 2), 2.0);
      }
      put(Outdoor::kBuilding, houseShapes(dice_, dice_.between(14.0, 18.0), dice_.between(9.0, 13.0)),
          stage_.spot(Vec2(side * (kHalfX + kPlaza + dice_.between(0.0, 3.0)), dice_.between(-3.0, 3.0)),
                      side > 0 ? std::numbers::pi : 0.0),
          0.5);
    }
  }

  /// Rows of bicycles in front of the halls.
  void addBicycleRacks() {
    for (const double side : {-1.0, 1.0}) {
      const double start = dice_.between(-12.0, 4.0), y = side * (kHalfY + dice_.between(4.0, 7.0));
      const std::size_t places = 5 + dice_.below(4);
      for (std::size_t i = 0; i < places; ++i) {
        const Spot spot = stage_.spot(Vec2(start + 1.15 * static_cast<double>(i), y),
                                      std::numbers::pi / 2 + dice_.between(-0.1, 0.1));
        parkBicycle(spot);
      }
    }
  }

  void parkBicycle(const Spot& spot) {
    const bool taken = dice_.chance(0.65), changes = dice_.chance(0.5 * dynamics_);
    const auto bicycle = taken || changes ? put(Outdoor::kBicycle, bicycleShapes(), spot, 0.25) : std::nullopt;
    if (bicycle && changes) {
      taken ? stage_.takeAway(*bicycle) : stage_.bring(*bicycle);
    }
  }

  /// One each, in the forecourts: the janitor's truck, a visitor's car, a coffee trailer, a motorcycle.
  void addRareVehicles() {
    const double side = dice_.chance(0.5) ? 1.0 : -1.0;
    const auto park = [&](Outdoor label, const Shapes& shapes, double lo, double hi, double forecourt) {
      const Vec2 p(dice_.between(lo, hi), forecourt * (kHalfY + kForecourt - 0.5));
      put(label, shapes, stage_.spot(p, dice_.between(-0.2, 0.2)), 0.6);
    };
    park(Outdoor::kTruck, vanShapes(dice_), -20.0, -13.0, side);
    park(Outdoor::kCar, carShapes(dice_), 11.0, 19.0, side);
    park(Outdoor::kOtherVehicle, caravanShapes(), -20.0, -13.0, -side);
    park(Outdoor::kMotorcycle, motorcycleShapes(), 11.0, 19.0, -side);
  }

  void addLamps() {
    const double start = dice_.between(0.0, 9.0);
    for (double s = start; s < way_.length(); s += 11.0) {
      put(Outdoor::kPole, lampPostShapes(dice_.between(3.2, 4.6)), beside(s, kPath + 0.4, 0.0), 0.6);
    }
  }

  /// Benches that face the way, some with a bin beside them.
  void addSeats() {
    for (double s = dice_.between(2.0, 6.0); s < way_.length(); s += dice_.between(6.0, 9.0)) {
      const double d = (dice_.chance(0.5) ? 1.0 : -1.0) * (kPath + dice_.between(0.5, 0.9));
      const double length = dice_.between(1.4, 2.2);
      if (put(Outdoor::kBench, benchShapes(length), beside(s, d, 0.0), 0.8) && dice_.chance(0.6)) {
        const double apart = 0.5 * length + dice_.between(0.9, 1.2);
        put(Outdoor::kBin, binShapes(dice_), beside(s + apart, d, 0.0), 0.5);
      }
    }
  }

  /// Trees, bushes, signs and hedges over the lawns.
  void scatter() {
    constexpr int kTries = 220;
    for (int i = 0; i < kTries; ++i) {
      const Vec2 p(dice_.between(-24.0, 24.0), dice_.between(-16.0, 16.0));
      if (groundAt(p) != Outdoor::kTerrain) {
        continue;
      }
      const Spot spot = stage_.spot(p, dice_.between(-std::numbers::pi, std::numbers::pi));
      const double kind = dice_.between(0.0, 1.0);
      if (kind < 0.5) {
        putTree(stage_, treeShapes(dice_), spot, 2.2);
      } else if (kind < 0.7) {
        put(Outdoor::kVegetation, bushShapes(dice_.between(0.4, 0.9)), spot, 1.0);
      } else if (kind < 0.8) {
        put(Outdoor::kVegetation, hedgeShapes(dice_.between(2.0, 5.0), dice_.between(0.7, 1.3)), spot, 1.0);
      } else if (kind < 0.9) {
        put(Outdoor::kTrafficSign, signShapes(dice_), spot, 1.2);
      } else {
        put(Outdoor::kPerson, personShapes(dice_, 0.0), spot, 1.2);
      }
    }
  }

  void addPeople() {
    const int people = static_cast<int>(std::lround(10.0 * dynamics_));
    for (int i = 0; i < people; ++i) {
      std::vector<Vec2> corners = ring(i % 2 == 0 ? 1.0 : -1.0);
      if (i % 4 < 2) {
        std::ranges::reverse(corners);
      }
      stage_.send(objectOf(Outdoor::kPerson), personShapes(dice_, 1.0),
                  Journey({corners, 4.0}, dice_.between(1.0, 1.45), 1.5), dice_.between(6.0, 80.0));
    }
  }

  Stage& stage_;
  const Way& way_;
  Dice dice_;
  double dynamics_;
};

}  // namespace

Scene makeCampus(std::uint64_t seed, double dynamics, bool plates) {
  const Journey travel({ring(0.0), 6.0}, 1.5, 1.0);
  Scene scene;
  scene.T_world_body = bodyOn(travel, height, {.height = kSensorHeight, .sway = 0.015, .bob = 0.015});
  scene.duration = kLaps * travel.lapTime();
  Stage stage(scene, height, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 1.5);
  Builder builder(stage, travel.way(), seed, dynamics);
  builder.build();
  if (plates) {
    builder.addPlates(Dice(seed, 18));
  }
  return scene;
}

}  // namespace hgg
