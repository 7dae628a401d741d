#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/worlds/indoor.h"

namespace hgg {
namespace {

/// Two rows of columns, a walk around them.
constexpr double kHalfX = 19.0, kHalfY = 8.0;
constexpr double kWalkX = 16.0, kWalkY = 5.0;
constexpr double kRow = 2.6, kFirstColumn = -14.0, kColumnStep = 4.0;  // y of the rows; x
constexpr int kColumns = 8;
constexpr double kCeiling = 4.2;
constexpr double kSensorHeight = 0.7;
constexpr double kLaps = 2.05;

const Room kHall{{-kHalfX, -kHalfY}, {kHalfX, kHalfY}};

std::vector<Vec2> ring(double outside) {
  const double x = kWalkX + outside, y = kWalkY + outside;
  return {Vec2(0, -y), Vec2(x, -y), Vec2(x, y), Vec2(-x, y), Vec2(-x, -y)};
}

double columnX(int i) { return kFirstColumn + kColumnStep * i; }

void addWalls(House& house) {
  house.addFloor({-kHalfX, -kHalfY}, {kHalfX, kHalfY});
  house.addWall({-kHalfX, -kHalfY}, {kHalfX, -kHalfY}, {doorway(6.0), doorway(32.0)});
  house.addWall({-kHalfX, kHalfY}, {kHalfX, kHalfY}, {});
  house.addWall({-kHalfX, -kHalfY}, {-kHalfX, kHalfY}, {});
  house.addWall({kHalfX, -kHalfY}, {kHalfX, kHalfY}, {});
  house.addDoor({-kHalfX, -kHalfY}, {kHalfX, -kHalfY}, 6.0, 0.0);
  house.addDoor({-kHalfX, -kHalfY}, {kHalfX, -kHalfY}, 32.0, 0.0);
}

class Builder {
 public:
  Builder(Stage& stage, Dice& dice, double dynamics)
      : stage_(stage), dice_(dice), furnish_(stage, dice, dynamics), dynamics_(dynamics) {}

  void build() {
    addColumns();
    addTicketMachines();
    addStairs();
    addBenches();
    addSmallThings();
    addPeople();
  }

 private:
  std::optional<std::size_t> put(Indoor label, const Shapes& shapes, const Vec2& at, double yaw, double gap) {
    return stage_.put(objectOf(label), shapes, stage_.spot(at, yaw), gap);
  }

  void addColumns() {
    for (int i = 0; i < kColumns; ++i) {
      for (const double y : {-kRow, kRow}) {
        put(Indoor::kPillar, {Cylinder{Vec3::Zero(), 0.32, kCeiling}}, {columnX(i), y}, 0.0, 0.0);
      }
    }
  }

  /// A row of equal machines at the north wall, one at another place.
  void addTicketMachines() {
    const double start = dice_.between(-10.0, 2.0);
    for (int i = 0; i < 5; ++i) {
      put(Indoor::kTicketMachine, ticketMachineShapes(), {start + 1.5 * i, kHalfY - 0.5}, -std::numbers::pi / 2, 0.3);
    }
    put(Indoor::kTicketMachine, ticketMachineShapes(), {dice_.between(-6.0, 6.0), -kHalfY + 0.5}, std::numbers::pi / 2,
        0.3);
  }

  /// Steps up to the ends of the platform, between the rows.
  void addStairs() {
    constexpr double kStep = 0.3, kRise = 0.17;
    for (const double side : {-1.0, 1.0}) {
      Shapes steps;
      for (int i = 0; i < 10; ++i) {
        steps.push_back(block(kStep * i, 0, 0, kStep, 2.4, kRise * (i + 1)));
      }
      put(Indoor::kStairs, steps, {side * 7.0, 0.0}, side > 0 ? 0.0 : std::numbers::pi, 0.2);
    }
  }

  /// Between the columns, back to back with the middle, and along the south wall.
  void addBenches() {
    for (int i = 0; i + 1 < kColumns; ++i) {
      for (const double y : {-kRow, kRow}) {
        if (dice_.chance(0.75)) {
          put(Indoor::kBench, indoorBenchShapes(1.8), {columnX(i) + 0.5 * kColumnStep, y},
              y > 0 ? std::numbers::pi / 2 : -std::numbers::pi / 2, 0.4);
        }
      }
    }
    for (int i = 0; i < 4; ++i) {
      furnish_.againstWall(kHall, Indoor::kBench, indoorBenchShapes(dice_.between(1.4, 2.4)), 0, 1.0);
    }
  }

  void addSmallThings() {
    for (int i = 0; i < kColumns; i += 2) {
      const double side = dice_.chance(0.5) ? 1.0 : -1.0;
      put(Indoor::kBin, {Cylinder{Vec3::Zero(), 0.2, 0.85}}, {columnX(i) + 0.75, side * kRow}, 0.0, 0.13);
    }
    for (int i = 0; i < 3; ++i) {
      furnish_.againstWall(kHall, Indoor::kPlant, plantShapes(dice_), -1, 0.8);
      furnish_.againstWall(kHall, Indoor::kBin, {Cylinder{Vec3::Zero(), 0.2, 0.85}}, -1, 0.6);
      furnish_.inside({{-15.0, -2.0}, {15.0, 2.0}}, Indoor::kSign, standeeShapes(dice_), 0.6);
    }
    furnish_.againstWall(kHall, Indoor::kCounter, counterShapes(2.0), 1);
    furnish_.againstWall(kHall, Indoor::kBox, boxShapes(dice_), 3);
    for (double x = -16.0; x <= 16.0; x += 4.0) {
      addPoster(x, kHalfY);
      addPoster(x, -kHalfY);
    }
    for (int i = 0; i < 4; ++i) {
      furnish_.inside({{-15.0, -2.2}, {15.0, 2.2}}, Indoor::kPerson, personShapes(dice_, 0.0), 0.5);
    }
  }

  /// Equal posters at equal distances; some frames are empty.
  void addPoster(double x, double y) {
    const Room frame{{x - 0.85, -kHalfY}, {x + 0.85, kHalfY}};
    if (dice_.chance(0.8)) {
      furnish_.hang(frame, Indoor::kPicture, pictureShapes(1.4, 1.1, 2.4), y > 0 ? 2 : 0);
    }
  }

  void addPeople() {
    const int people = static_cast<int>(std::lround(8.0 * dynamics_));
    for (int i = 0; i < people; ++i) {
      std::vector<Vec2> corners = ring(i % 2 == 0 ? 1.0 : -1.0);
      if (i % 4 < 2) {
        std::ranges::reverse(corners);
      }
      stage_.send(objectOf(Indoor::kPerson), personShapes(dice_, 1.0),
                  Journey({corners, 3.0}, dice_.between(1.0, 1.4), 1.5), dice_.between(6.0, 80.0));
    }
  }

  Stage& stage_;
  Dice& dice_;
  Furnisher furnish_;
  double dynamics_;
};

}  // namespace

Scene makeHall(std::uint64_t seed, double dynamics) {
  const Height floor = [](const Vec2& /*p*/) { return 0.0; };
  const Journey travel({ring(0.0), 4.0}, 1.5, 1.2);
  Scene scene;
  scene.label_space = "indoor";
  scene.T_world_body = bodyOn(travel, floor, {.height = kSensorHeight, .sway = 0.012, .bob = 0.01});
  scene.duration = kLaps * travel.lapTime();
  Dice dice(seed, 7);
  Stage stage(scene, floor, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 1.3);
  House house(stage, dice, kCeiling);
  addWalls(house);
  house.nameRoom("hall", {kHall});
  Builder(stage, dice, dynamics).build();
  return scene;
}

}  // namespace hgg
