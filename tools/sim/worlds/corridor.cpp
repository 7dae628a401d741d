#include <cmath>
#include <numbers>

#include "sim/worlds/indoor.h"

namespace hgg {
namespace {

/// A long corridor along x between two rows of four rooms.
constexpr double kLength = 28.0, kDepth = 4.6;  // of the corridor, of a room
constexpr double kSouthWall = kDepth, kNorthWall = kDepth + 2.2, kMiddle = 0.5 * (kSouthWall + kNorthWall);  // y
constexpr double kNorthEnd = kNorthWall + kDepth;                                                            // y
constexpr double kRoomEnds[] = {0.0, 7.0, 14.0, 21.0, 28.0};                                                 // x
constexpr double kDoors[] = {2.6, 9.6, 16.6, 23.6};  // x, of the rooms' doors, on both sides
constexpr double kTurn = 0.45;                       // m from the middle, where the way turns round
constexpr double kCeiling = 2.7;
constexpr double kSensorHeight = 0.65;

Room southRoom(std::size_t i) { return {{kRoomEnds[i], 0.0}, {kRoomEnds[i + 1], kSouthWall}}; }
Room northRoom(std::size_t i) { return {{kRoomEnds[i], kNorthWall}, {kRoomEnds[i + 1], kNorthEnd}}; }

/// Into a room through its door, around, and out again; `up` 1: north, -1: south. `turn`: which way around.
void visit(std::vector<Vec2>& corners, double door, double up, double turn) {
  const double wall = up > 0 ? kNorthWall : kSouthWall;
  const auto at = [&](double x, double in) { return Vec2(door + turn * x, wall + up * in); };
  corners.insert(corners.end(), {Vec2(door, kMiddle), at(0.0, 0.9), at(-0.7, 1.7), at(0.0, 2.4), at(0.7, 1.7),
                                 at(0.0, 0.9), Vec2(door, kMiddle)});
}

/// Up the corridor and back, with a room on the way there and one on the way back.
std::vector<Vec2> tour() {
  std::vector<Vec2> corners{Vec2(4.0, kMiddle)};
  visit(corners, kDoors[1], 1.0, -1.0);
  corners.insert(corners.end(), {Vec2(24.0, kMiddle - kTurn), Vec2(25.0, kMiddle), Vec2(24.0, kMiddle + kTurn)});
  visit(corners, kDoors[2], -1.0, -1.0);
  corners.insert(corners.end(), {Vec2(4.0, kMiddle + kTurn), Vec2(3.0, kMiddle)});
  return corners;
}

void addWalls(House& house) {
  house.addFloor({0, 0}, {kLength, kNorthEnd});
  std::vector<Opening> doorways, windows;
  for (std::size_t i = 0; i < 4; ++i) {
    doorways.push_back(doorway(kDoors[i]));
    windows.push_back(windowAt(kRoomEnds[i] + 3.5, 1.6));
  }
  house.addWall({0, 0}, {kLength, 0}, windows);
  house.addWall({0, kNorthEnd}, {kLength, kNorthEnd}, windows);
  house.addWall({0, 0}, {0, kNorthEnd}, {});
  house.addWall({kLength, 0}, {kLength, kNorthEnd}, {});
  house.addWall({0, kSouthWall}, {kLength, kSouthWall}, doorways);
  house.addWall({0, kNorthWall}, {kLength, kNorthWall}, doorways);
  for (std::size_t i = 1; i < 4; ++i) {
    house.addWall({kRoomEnds[i], 0}, {kRoomEnds[i], kSouthWall}, {});
    house.addWall({kRoomEnds[i], kNorthWall}, {kRoomEnds[i], kNorthEnd}, {});
  }
}

void addDoors(House& house) {
  constexpr double kOpen = std::numbers::pi / 2;
  for (const double at : kDoors) {
    house.addDoor({0, kSouthWall}, {kLength, kSouthWall}, at, -kOpen);
    house.addDoor({0, kNorthWall}, {kLength, kNorthWall}, at, kOpen);
  }
}

const Room kCorridor{{0.0, kSouthWall}, {kLength, kNorthWall}};

void nameRooms(House& house) {
  for (std::size_t i = 0; i < 4; ++i) {
    house.nameRoom("south " + std::to_string(i), {southRoom(i)});
    house.nameRoom("north " + std::to_string(i), {northRoom(i)});
  }
  house.nameRoom("corridor", {kCorridor});
}

void furnishRoom(Furnisher& furnish, Dice& dice, const Room& room) {
  furnish.againstWall(room, Indoor::kBed, bedShapes(0.9), -1, 0.2);
  if (dice.chance(0.5)) {
    furnish.againstWall(room, Indoor::kBed, bedShapes(0.9), -1, 0.2);
  }
  furnish.againstWall(room, Indoor::kCabinet, cabinetShapes(dice));
  furnish.againstWall(room, Indoor::kCabinet, cabinetShapes(dice));
  furnish.tableWithChairs(room, dice.between(0.9, 1.3), 0.7);
  furnish.againstWall(room, Indoor::kSink, sinkShapes());
  furnish.againstWall(room, Indoor::kPlant, plantShapes(dice));
  if (dice.chance(0.5)) {
    furnish.againstWall(room, Indoor::kLamp, lampShapes(dice));
  }
  furnish.hang(room, Indoor::kPicture, pictureShapes(dice.between(0.5, 1.0), dice.between(0.4, 0.7), 1.6));
}

void furnishCorridor(Furnisher& furnish, Dice& dice) {
  for (int i = 0; i < 2; ++i) {
    furnish.againstWall(kCorridor, Indoor::kPlant, plantShapes(dice));
    furnish.againstWall(kCorridor, Indoor::kBin, wasteBinShapes(dice));
    furnish.hang(kCorridor, Indoor::kPicture, pictureShapes(dice.between(0.5, 1.2), dice.between(0.5, 0.8), 1.6));
  }
}

}  // namespace

Scene makeCorridor(std::uint64_t seed, double dynamics) {
  const Height floor = [](const Vec2& /*p*/) { return 0.0; };
  const Journey travel({tour(), 1.3}, 1.2, 1.6);
  Scene scene;
  scene.label_space = "indoor";
  scene.T_world_body = bodyOn(travel, floor, {.height = kSensorHeight, .sway = 0.012, .bob = 0.01});
  scene.duration = 1.02 * travel.lapTime();
  Dice dice(seed, 8);
  Stage stage(scene, floor, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 0.38);
  House house(stage, dice, kCeiling);
  addWalls(house);
  addDoors(house);
  nameRooms(house);
  Furnisher furnish(stage, dice, dynamics);
  for (std::size_t i = 0; i < 4; ++i) {
    furnishRoom(furnish, dice, southRoom(i));
    furnishRoom(furnish, dice, northRoom(i));
  }
  furnishCorridor(furnish, dice);
  return scene;
}

}  // namespace hgg
