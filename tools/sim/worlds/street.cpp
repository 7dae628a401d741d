#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

/// The middle of the road is a rectangle with these half sides; `offset` d is m outwards from it.
constexpr double kHalfX = 30.0, kHalfY = 21.0;
constexpr double kRoad = 5.2, kSidewalk = 7.7;      // edges, by |d|
constexpr double kBayStart = 3.7, kBayEnd = 8.4;    // cars side by side, outside the south side
constexpr double kBayHalf = 22.0, kBayWalk = 10.4;  // half its length; the end of the sidewalk behind it
constexpr double kLane = 1.5;                       // d of the sensor's lane; oncoming cars at -d
constexpr double kSideStreet = 4.0;                 // half width
constexpr double kOuter = 75.0;
constexpr double kSensorHeight = 1.7;
constexpr double kLaps = 2.05;

double height(const Vec2& p) { return 1.4 * std::sin(p.x() / 28.0 + 0.4) + 0.9 * std::sin(p.y() / 19.0); }

/// The four sides, counter-clockwise from the south: `s` m along from the middle, `d` outwards.
struct Side {
  Vec2 middle, along;
  double half;

  Spot spot(double s, double d, double turn) const {
    const Vec2 outward(along.y(), -along.x());
    const Vec2 p = middle + s * along + d * outward;
    return {Vec3(p.x(), p.y(), height(p)), std::atan2(along.y(), along.x()) + turn};
  }
};
constexpr double kAlong = 0.0, kOutward = -std::numbers::pi / 2, kInward = std::numbers::pi / 2;

const Side kSouth{Vec2(0, -kHalfY), Vec2(1, 0), kHalfX};
const Side kSides[] = {kSouth,
                       {Vec2(kHalfX, 0), Vec2(0, 1), kHalfY},
                       {Vec2(0, kHalfY), Vec2(-1, 0), kHalfX},
                       {Vec2(-kHalfX, 0), Vec2(0, -1), kHalfY}};

std::vector<Vec2> ring(double d) {
  const double x = kHalfX + d, y = kHalfY + d;
  return {Vec2(0, -y), Vec2(x, -y), Vec2(x, y), Vec2(-x, y), Vec2(-x, -y)};
}

/// Two streets lead away from opposite corners.
bool onSideStreet(const Vec2& p) {
  return std::abs(std::abs(p.y()) - kHalfY) < kSideStreet && p.x() * p.y() < 0 && std::abs(p.x()) > kHalfX;
}

Outdoor groundAt(const Vec2& p) {
  const double d = std::max(std::abs(p.x()) - kHalfX, std::abs(p.y()) - kHalfY);
  const double south = -p.y() - kHalfY;
  if (std::abs(p.x()) < kBayHalf && south > kBayStart && south < kBayWalk) {
    return south < kBayEnd ? Outdoor::kParking : Outdoor::kSidewalk;
  }
  if (std::abs(d) < kRoad || onSideStreet(p)) {
    return Outdoor::kRoad;
  }
  return std::abs(d) < kSidewalk ? Outdoor::kSidewalk : Outdoor::kTerrain;
}

void addGrounds(World& world) {
  constexpr double kWidest = 4.0;
  std::vector<double> x_stops{-kOuter, -kBayHalf, kBayHalf, kOuter}, y_stops{-kOuter, kOuter};
  for (const double sign : {-1.0, 1.0}) {
    for (const double d : {-kSidewalk, -kRoad, kRoad, kSidewalk}) {
      x_stops.push_back(sign * (kHalfX + d));
      y_stops.push_back(sign * (kHalfY + d));
    }
    y_stops.insert(y_stops.end(), {sign * (kHalfY - kSideStreet), sign * (kHalfY + kSideStreet)});
  }
  y_stops.insert(y_stops.end(), {-kHalfY - kBayStart, -kHalfY - kBayEnd, -kHalfY - kBayWalk});
  std::ranges::sort(x_stops);
  std::ranges::sort(y_stops);
  std::map<Outdoor, std::size_t> objects;
  for (const Outdoor label : {Outdoor::kRoad, Outdoor::kSidewalk, Outdoor::kParking, Outdoor::kTerrain}) {
    objects[label] = addObject(world, objectOf(label), {});
  }
  addGround(world, gridLines(x_stops, kWidest), gridLines(y_stops, kWidest), height,
            [&](const Vec2& center) { return std::optional(objects.at(groundAt(center))); });
}

/// Puts things on the stage where there is room.
class Builder {
 public:
  Builder(Stage& stage, std::uint64_t seed, double dynamics) : stage_(stage), dice_(seed, 1), dynamics_(dynamics) {}

  /// Small signs on poles along the kerbs, last of all and by dice of their own: what stands there stays.
  void addPlates(Dice dice) {
    for (const Side& side : kSides) {
      for (const double sign : {-1.0, 1.0}) {
        for (double s = -side.half + 4.0; s < side.half - 3.0; s += dice.between(6.0, 10.0)) {
          putPlate(stage_, dice, side.spot(s, sign * 5.6, dice.chance(0.5) ? kAlong : -std::numbers::pi), 0.5);
        }
      }
    }
  }

  void build() {
    addGrounds(stage_.world());
    stage_.layout().claim({Vec2(kHalfX + 30.0, -kHalfY), Vec2(28.0, kSideStreet + 1.0), 0.0});
    stage_.layout().claim({Vec2(-kHalfX - 30.0, kHalfY), Vec2(28.0, kSideStreet + 1.0), 0.0});
    addBay();
    addRareVehicles();
    for (const Side& side : kSides) {
      addHouses(side, kHalfX);
      addParking(side);
      addKerb(side);
      addFronts(side);
    }
    addMovers();
  }

 private:
  std::optional<std::size_t> put(Outdoor label, const Shapes& shapes, const Spot& spot, double gap) {
    return stage_.put(objectOf(label), shapes, spot, gap);
  }

  void addBay() {
    for (double s = -kBayHalf + 1.5; s < kBayHalf - 1.0; s += dice_.between(2.45, 2.75)) {
      const double turn = dice_.chance(0.7) ? kInward : kOutward;
      park(kSouth.spot(s, 0.5 * (kBayStart + kBayEnd) + dice_.between(-0.15, 0.15), turn), 0.8);
    }
  }

  /// One each: a bus at its stop, a caravan, a motorcycle.
  void addRareVehicles() {
    const Side &bus_side = kSides[2], &caravan_side = kSides[dice_.chance(0.5) ? 1 : 3];
    const double stop = dice_.between(-12.0, 10.0);
    put(Outdoor::kBus, busShapes(), bus_side.spot(stop, 4.45, kAlong), 0.5);
    put(Outdoor::kBench, benchShapes(2.0), bus_side.spot(stop + dice_.between(0.0, 3.0), 7.0, kInward), 0.5);
    put(Outdoor::kOtherVehicle, caravanShapes(), caravan_side.spot(dice_.between(-6.0, 6.0), -4.25, kAlong), 0.5);
    const Side& motorcycle_side = kSides[dice_.below(4)];
    put(Outdoor::kMotorcycle, motorcycleShapes(), motorcycle_side.spot(dice_.between(-10.0, 10.0), -5.75, kAlong), 0.4);
  }

  void addParking(const Side& side) {
    for (const double d : {-4.2, 4.2}) {
      if (&side == &kSides[0] && d > 0) {
        continue;
      }
      for (double s = -side.half + 9.0; s < side.half - 9.0; s += dice_.between(5.3, 6.2)) {
        park(side.spot(s, d + dice_.between(-0.12, 0.12), kAlong + dice_.between(-0.03, 0.03)), 0.7);
      }
    }
  }

  /// A slot is taken or free, and that may change between the laps.
  void park(const Spot& spot, double share_taken) {
    const bool taken = dice_.chance(share_taken), changes = dice_.chance(0.3 * dynamics_), van = dice_.chance(0.08);
    const Shapes shapes = van ? vanShapes(dice_) : carShapes(dice_);
    if (!taken && !changes) {
      return;
    }
    const auto car = put(van ? Outdoor::kTruck : Outdoor::kCar, shapes, spot, 0.35);
    if (car && changes) {
      taken ? stage_.takeAway(*car) : stage_.bring(*car);
    }
  }

  void addHouses(const Side& side, double beyond) {
    for (double s = -side.half - beyond; s < side.half + beyond; s += dice_.between(10.0, 13.0)) {
      const double front = &side == &kSides[0] ? kBayWalk + 2.5 : 11.0 + dice_.between(0.0, 2.0);
      put(Outdoor::kBuilding, houseShapes(dice_, dice_.between(7.5, 10.0), dice_.between(8.0, 11.0)),
          side.spot(s, front, kInward), 1.5);
    }
    for (double s = -side.half + 14.0; s < side.half - 13.0; s += dice_.between(9.5, 11.5)) {
      put(Outdoor::kBuilding, houseShapes(dice_, dice_.between(7.0, 8.5), dice_.between(5.5, 7.0)),
          side.spot(s, -9.8 - dice_.between(0.0, 1.0), kOutward), 1.5);
    }
  }

  /// Between road and sidewalk: lamps at equal distances, trees, signs, bins, people that stand and talk.
  void addKerb(const Side& side) {
    for (const double sign : {-1.0, 1.0}) {
      const double facing_road = sign > 0 ? kInward : kOutward;
      for (double s = -side.half + 6.0; s < side.half - 5.0; s += 14.0) {
        put(Outdoor::kPole, lampPostShapes(dice_.between(5.0, 7.0)), side.spot(s, sign * 5.9, facing_road), 0.5);
      }
      for (double s = -side.half + 3.0; s < side.half - 2.0; s += dice_.between(2.5, 4.0)) {
        addKerbThing(side, s, sign, facing_road);
      }
    }
  }

  void addKerbThing(const Side& side, double s, double sign, double facing_road) {
    constexpr double kGap = 0.8;
    const double kind = dice_.between(0.0, 1.0);
    if (kind < 0.3) {
      putTree(stage_, treeShapes(dice_), side.spot(s, sign * 6.0, 0.0), kGap);
    } else if (kind < 0.45) {
      put(Outdoor::kTrafficSign, signShapes(dice_),
          side.spot(s, sign * 5.7, dice_.chance(0.5) ? kAlong : -std::numbers::pi), kGap);
    } else if (kind < 0.55) {
      put(Outdoor::kBin, binShapes(dice_), side.spot(s, sign * 5.9, facing_road), kGap);
    } else if (kind < 0.62) {
      put(Outdoor::kPole, poleShapes(dice_.between(1.0, 4.0)), side.spot(s, sign * 5.7, 0.0), kGap);
    } else if (kind < 0.70) {
      put(Outdoor::kBicycle, bicycleShapes(), side.spot(s, sign * 6.0, kAlong), kGap);
    } else if (kind < 0.75) {
      put(Outdoor::kBench, benchShapes(1.6), side.spot(s, sign * 6.1, -facing_road), kGap);
    } else if (kind < 0.82) {
      put(Outdoor::kPerson, personShapes(dice_, 0.0), side.spot(s, sign * 6.1, dice_.between(0.0, 6.0)), kGap);
    }
  }

  /// Where sidewalk meets garden.
  void addFronts(const Side& side) {
    for (const double d : {-8.3, 8.3}) {
      const double turn = d > 0 ? kInward : kOutward;
      for (double s = -side.half + 8.0; s < side.half - 6.0; s += dice_.between(6.0, 9.0)) {
        const double length = dice_.between(3.0, 5.5), kind = dice_.between(0.0, 1.0);
        if (kind < 0.4) {
          put(Outdoor::kFence, fenceShapes(length), side.spot(s, d, turn), 0.4);
        } else if (kind < 0.7) {
          put(Outdoor::kVegetation, hedgeShapes(length, dice_.between(0.9, 1.7)), side.spot(s, d, turn), 0.4);
        } else {
          put(Outdoor::kVegetation, bushShapes(dice_.between(0.5, 0.9)), side.spot(s, d, 0.0), 0.4);
        }
      }
    }
  }

  void addMovers() {
    const auto count = [&](double most) { return static_cast<int>(std::lround(most * dynamics_)); };
    const auto oncoming = ring(-kLane);
    const Journey against({{oncoming.rbegin(), oncoming.rend()}, 14.0}, 7.0, 0.8);
    const Journey along({ring(kLane), 14.0}, 7.6, 0.8);
    for (int i = 0; i < count(3); ++i) {
      stage_.send(objectOf(Outdoor::kCar), carShapes(dice_), against, 30.0 + 65.0 * i + dice_.between(-8.0, 8.0));
    }
    for (int i = 0; i < count(2); ++i) {
      stage_.send(objectOf(Outdoor::kCar), carShapes(dice_), along, 18.0 + 60.0 * i);
    }
    auto sidewalk = ring(-7.0);
    for (int i = 0; i < count(8); ++i) {
      const bool reversed = i % 2 == 1;
      const std::vector<Vec2> corners = reversed ? std::vector<Vec2>(sidewalk.rbegin(), sidewalk.rend()) : sidewalk;
      stage_.send(objectOf(Outdoor::kPerson), personShapes(dice_, 1.0),
                  Journey({corners, 3.0}, dice_.between(1.1, 1.5), 1.5), dice_.between(0.0, 150.0));
    }
  }

  Stage& stage_;
  Dice dice_;
  double dynamics_;
};

}  // namespace

Scene makeStreet(std::uint64_t seed, double dynamics, bool plates) {
  const Journey travel({ring(kLane), 14.0}, 7.6, 0.8);
  Scene scene;
  scene.T_world_body = bodyOn(travel, height, {.height = kSensorHeight, .sway = 0.008, .bob = 0.02});
  scene.duration = kLaps * travel.lapTime();
  Stage stage(scene, height, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 1.3);
  Builder builder(stage, seed, dynamics);
  builder.build();
  if (plates) {
    builder.addPlates(Dice(seed, 17));
  }
  return scene;
}

}  // namespace hgg
