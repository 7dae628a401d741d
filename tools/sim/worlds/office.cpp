#include <cmath>
#include <numbers>

#include "sim/worlds/indoor.h"

namespace hgg {
namespace {

/// A core, a corridor around it, rooms around that.
constexpr double kLengthX = 26.0, kLengthY = 18.0;
constexpr double kCoreX0 = 6.0, kCoreX1 = 20.0, kCoreY0 = 7.0, kCoreY1 = 11.0;
constexpr double kRingX0 = 4.0, kRingX1 = 22.0, kRingY0 = 5.0, kRingY1 = 13.0;
constexpr double kMidX0 = 5.0, kMidX1 = 21.0, kMidY0 = 6.0, kMidY1 = 12.0;  // the corridor's middle
constexpr double kRoomEnds[] = {0.0, 6.5, 13.0, 19.5, 26.0};                // x, of the rooms north and south
constexpr double kDoors[] = {5.2, 9.7, 16.3, 20.8};                         // x, into those rooms
constexpr double kSideDoor = 9.0;                                           // y, into the rooms east and west
constexpr double kCeiling = 2.8;
constexpr double kSensorHeight = 0.65;
constexpr double kLaps = 2.05;

Room southRoom(std::size_t i) { return {{kRoomEnds[i], 0.0}, {kRoomEnds[i + 1], kRingY0}}; }
Room northRoom(std::size_t i) { return {{kRoomEnds[i], kRingY1}, {kRoomEnds[i + 1], kLengthY}}; }
const Room kWestRoom{{0.0, kRingY0}, {kRingX0, kRingY1}};
const Room kEastRoom{{kRingX1, kRingY0}, {kLengthX, kRingY1}};

/// Into a room through its door, around, and out again; `up` 1: north, -1: south. `turn`: which way around.
void visit(std::vector<Vec2>& corners, double door, double up, double turn) {
  const double wall = up > 0 ? kRingY1 : kRingY0, middle = up > 0 ? kMidY1 : kMidY0;
  const auto at = [&](double x, double in) { return Vec2(door + turn * x, wall + up * in); };
  corners.insert(corners.end(), {Vec2(door, middle), at(0.0, 1.0), at(-0.9, 1.9), at(0.0, 2.8), at(0.9, 1.9),
                                 at(0.0, 1.0), Vec2(door, middle)});
}

std::vector<Vec2> tour() {
  std::vector<Vec2> corners{Vec2(kMidX0, kMidY0)};
  visit(corners, kDoors[1], -1.0, 1.0);
  corners.emplace_back(kMidX1, kMidY0);
  corners.emplace_back(kMidX1, kMidY1);
  visit(corners, kDoors[2], 1.0, 1.0);
  visit(corners, kDoors[1], 1.0, -1.0);
  corners.emplace_back(kMidX0, kMidY1);
  return corners;
}

std::vector<Vec2> ring(double inset) {
  return {Vec2(13.0, kMidY0 + inset), Vec2(kMidX1 - inset, kMidY0 + inset), Vec2(kMidX1 - inset, kMidY1 - inset),
          Vec2(kMidX0 + inset, kMidY1 - inset), Vec2(kMidX0 + inset, kMidY0 + inset)};
}

std::vector<Opening> doorways() {
  std::vector<Opening> openings;
  for (const double at : kDoors) {
    openings.push_back(doorway(at));
  }
  return openings;
}

std::vector<Opening> windows() {
  std::vector<Opening> openings;
  for (double x = 1.7; x < kLengthX; x += 3.25) {
    openings.push_back(windowAt(x, 1.8));
  }
  return openings;
}

void addWalls(House& house) {
  house.addFloor({0, 0}, {kLengthX, kLengthY});
  house.addWall({0, 0}, {kLengthX, 0}, windows());
  house.addWall({0, kLengthY}, {kLengthX, kLengthY}, windows());
  house.addWall({0, 0}, {0, kLengthY}, {windowAt(9.0, 2.5)});
  house.addWall({kLengthX, 0}, {kLengthX, kLengthY}, {windowAt(9.0, 2.5)});
  house.addWall({0, kRingY0}, {kLengthX, kRingY0}, doorways());
  house.addWall({0, kRingY1}, {kLengthX, kRingY1}, doorways());
  house.addWall({kRingX0, kRingY0}, {kRingX0, kRingY1}, {doorway(kSideDoor - kRingY0)});
  house.addWall({kRingX1, kRingY0}, {kRingX1, kRingY1}, {doorway(kSideDoor - kRingY0)});
  for (std::size_t i = 1; i < 4; ++i) {
    house.addWall({kRoomEnds[i], 0}, {kRoomEnds[i], kRingY0}, {});
    house.addWall({kRoomEnds[i], kRingY1}, {kRoomEnds[i], kLengthY}, {});
  }
  house.addWall({kCoreX0, kCoreY0}, {kCoreX1, kCoreY0}, {doorway(4.0)});
  house.addWall({kCoreX0, kCoreY1}, {kCoreX1, kCoreY1}, {doorway(10.0)});
  house.addWall({kCoreX0, kCoreY0}, {kCoreX0, kCoreY1}, {});
  house.addWall({kCoreX1, kCoreY0}, {kCoreX1, kCoreY1}, {});
}

void addDoors(House& house) {
  constexpr double kOpen = std::numbers::pi / 2;
  for (const double at : kDoors) {
    house.addDoor({0, kRingY0}, {kLengthX, kRingY0}, at, -kOpen);
    house.addDoor({0, kRingY1}, {kLengthX, kRingY1}, at, kOpen);
  }
  house.addDoor({kCoreX0, kCoreY0}, {kCoreX1, kCoreY0}, 4.0, 0.0);
  house.addDoor({kCoreX0, kCoreY1}, {kCoreX1, kCoreY1}, 10.0, 0.0);
}

/// The four sides of the corridor around the core.
std::vector<Room> corridors() {
  return {{{kRingX0, kRingY0}, {kRingX1, kCoreY0}},
          {{kRingX0, kCoreY1}, {kRingX1, kRingY1}},
          {{kRingX0, kRingY0}, {kCoreX0, kRingY1}},
          {{kCoreX1, kRingY0}, {kRingX1, kRingY1}}};
}

void nameRooms(House& house) {
  for (std::size_t i = 0; i < 4; ++i) {
    house.nameRoom("south " + std::to_string(i), {southRoom(i)});
    house.nameRoom("north " + std::to_string(i), {northRoom(i)});
  }
  house.nameRoom("west", {kWestRoom}), house.nameRoom("east", {kEastRoom});
  house.nameRoom("corridor", corridors());
  house.nameRoom("core", {{{kCoreX0, kCoreY0}, {kCoreX1, kCoreY1}}});
}

void furnishOffice(Furnisher& furnish, Dice& dice, const Room& room) {
  const std::size_t desks = 2 + dice.below(3);
  for (std::size_t i = 0; i < desks; ++i) {
    furnish.workplace(room);
  }
  furnish.againstWall(room, Indoor::kShelf, shelfShapes(dice.between(0.8, 1.2), dice.between(1.4, 2.1)));
  if (dice.chance(0.6)) {
    furnish.againstWall(room, Indoor::kCabinet, cabinetShapes(dice));
  }
  furnish.againstWall(room, Indoor::kBin, wasteBinShapes(dice));
  if (dice.chance(0.5)) {
    furnish.againstWall(room, Indoor::kPlant, plantShapes(dice));
  }
  if (dice.chance(0.4)) {
    furnish.againstWall(room, Indoor::kLamp, lampShapes(dice));
  }
  if (dice.chance(0.5)) {
    furnish.inside(room, Indoor::kBox, boxShapes(dice));
  }
  furnish.hang(room, Indoor::kPicture, pictureShapes(dice.between(0.6, 1.6), dice.between(0.5, 0.9), 1.6));
}

void furnishSideRooms(Furnisher& furnish, Dice& dice) {
  furnish.tableWithChairs(kEastRoom, dice.between(2.6, 3.4), 1.1);
  furnish.hang(kEastRoom, Indoor::kMonitor, pictureShapes(1.3, 0.75, 1.5));
  furnish.againstWall(kEastRoom, Indoor::kCabinet, cabinetShapes(dice));
  furnish.againstWall(kEastRoom, Indoor::kPlant, plantShapes(dice));

  furnish.againstWall(kWestRoom, Indoor::kCounter, counterShapes(2.2), 3);
  furnish.againstWall(kWestRoom, Indoor::kFridge, fridgeShapes());
  furnish.againstWall(kWestRoom, Indoor::kSink, sinkShapes());
  furnish.tableWithChairs(kWestRoom, 1.3, 0.8);
  furnish.againstWall(kWestRoom, Indoor::kSofa, sofaShapes(1.7));
  furnish.againstWall(kWestRoom, Indoor::kBin, wasteBinShapes(dice));
}

/// Flat things along the corridor's walls.
void furnishCorridor(Furnisher& furnish, Dice& dice) {
  for (const Room& corridor : corridors()) {
    furnish.againstWall(corridor, Indoor::kBin, wasteBinShapes(dice));
    furnish.againstWall(corridor, Indoor::kPlant, plantShapes(dice));
    furnish.againstWall(corridor, Indoor::kBench, indoorBenchShapes(dice.between(1.0, 1.5)));
    furnish.againstWall(corridor, Indoor::kBox, boxShapes(dice));
    for (int i = 0; i < 3; ++i) {
      furnish.hang(corridor, Indoor::kPicture, pictureShapes(dice.between(0.5, 1.2), dice.between(0.5, 0.8), 1.6));
    }
  }
}

}  // namespace

Scene makeOffice(std::uint64_t seed, double dynamics) {
  const Height floor = [](const Vec2& /*p*/) { return 0.0; };
  const Journey travel({tour(), 1.8}, 1.5, 1.9);
  Scene scene;
  scene.label_space = "indoor";
  scene.T_world_body = bodyOn(travel, floor, {.height = kSensorHeight, .sway = 0.012, .bob = 0.01});
  scene.duration = kLaps * travel.lapTime();
  Dice dice(seed, 6);
  Stage stage(scene, floor, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 0.4);
  House house(stage, dice, kCeiling);
  addWalls(house);
  addDoors(house);
  nameRooms(house);
  Furnisher furnish(stage, dice, dynamics);
  furnishSideRooms(furnish, dice);
  for (std::size_t i = 0; i < 4; ++i) {
    furnishOffice(furnish, dice, southRoom(i));
    furnishOffice(furnish, dice, northRoom(i));
  }
  furnishCorridor(furnish, dice);
  for (int i = 0; i < static_cast<int>(std::lround(4.0 * dynamics)); ++i) {
    stage.send(objectOf(Indoor::kPerson), personShapes(dice, 1.0), Journey({ring(0.6), 1.0}, 1.1, 1.5),
               10.0 + 11.0 * i);
  }
  return scene;
}

}  // namespace hgg
