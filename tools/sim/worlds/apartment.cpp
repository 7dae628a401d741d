#include <cmath>
#include <numbers>

#include "sim/worlds/indoor.h"

namespace hgg {
namespace {

constexpr double kWest = 0.0, kEast = 13.0, kSouth = 0.0, kNorth = 10.0;
constexpr double kCorridorSouth = 4.2, kCorridorNorth = 5.8, kCorridor = 5.0;  // y
constexpr double kCeiling = 2.6;
constexpr double kSensorHeight = 0.65;
constexpr double kLaps = 2.05;

/// Corners of the rooms along the two sides of the corridor, x.
constexpr double kKitchenEnd = 4.0, kLivingEnd = 9.5;  // south: kitchen, living room, study
constexpr double kBedroomEnd = 4.5, kBathEnd = 7.0;    // north: bedroom, bath, large bedroom
constexpr double kKitchenDoor = 2.0, kLivingDoor = 5.3, kLivingSecondDoor = 8.3, kStudyDoor = 11.2;
constexpr double kBedroomDoor = 2.8, kBathDoor = 5.8, kLargeBedroomDoor = 9.5;

const Room kKitchen{{kWest, kSouth}, {kKitchenEnd, kCorridorSouth}};
const Room kLiving{{kKitchenEnd, kSouth}, {kLivingEnd, kCorridorSouth}};
const Room kStudy{{kLivingEnd, kSouth}, {kEast, kCorridorSouth}};
const Room kBedroom{{kWest, kCorridorNorth}, {kBedroomEnd, kNorth}};
const Room kBath{{kBedroomEnd, kCorridorNorth}, {kBathEnd, kNorth}};
const Room kLargeBedroom{{kBathEnd, kCorridorNorth}, {kEast, kNorth}};
const Room kHallway{{kWest, kCorridorSouth}, {kEast, kCorridorNorth}};

/// Into a room through a door in the corridor's wall, around, and out again; `up` 1: north, -1: south.
void visit(std::vector<Vec2>& corners, double door, double up) {
  const double wall = up > 0 ? kCorridorNorth : kCorridorSouth;
  const auto at = [&](double x, double in) { return Vec2(door + x, wall + up * in); };
  corners.insert(corners.end(), {Vec2(door, kCorridor), at(0.0, 0.9), at(-0.75, 1.6), at(0.0, 2.35), at(0.75, 1.6),
                                 at(0.0, 0.9), Vec2(door, kCorridor)});
}

std::vector<Vec2> tour() {
  std::vector<Vec2> corners{Vec2(3.9, kCorridor), Vec2(kLivingDoor, kCorridor), Vec2(kLivingDoor, 1.7),
                            Vec2(kLivingSecondDoor, 1.7), Vec2(kLivingSecondDoor, kCorridor)};
  visit(corners, kStudyDoor, -1.0);
  visit(corners, kLargeBedroomDoor, 1.0);
  visit(corners, kBedroomDoor, 1.0);
  visit(corners, kKitchenDoor, -1.0);
  return corners;
}

void addWalls(House& house) {
  house.addFloor({kWest, kSouth}, {kEast, kNorth});
  const auto windows = [](std::initializer_list<double> at) {
    std::vector<Opening> openings;
    for (const double x : at) {
      openings.push_back(windowAt(x, 1.3));
    }
    return openings;
  };
  house.addWall({kWest, kSouth}, {kEast, kSouth}, windows({2.0, 6.0, 8.0, 11.3}));
  house.addWall({kWest, kNorth}, {kEast, kNorth}, windows({2.2, 8.8, 11.4}));
  house.addWall({kWest, kSouth}, {kWest, kNorth}, {doorway(kCorridor)});
  house.addWall({kEast, kSouth}, {kEast, kNorth}, windows({2.2, 7.9}));
  house.addWall({kWest, kCorridorSouth}, {kEast, kCorridorSouth},
                {doorway(kKitchenDoor), doorway(kLivingDoor), doorway(kLivingSecondDoor), doorway(kStudyDoor)});
  house.addWall({kWest, kCorridorNorth}, {kEast, kCorridorNorth},
                {doorway(kBedroomDoor), doorway(kBathDoor), doorway(kLargeBedroomDoor)});
  for (const double x : {kKitchenEnd, kLivingEnd}) {
    house.addWall({x, kSouth}, {x, kCorridorSouth}, {});
  }
  for (const double x : {kBedroomEnd, kBathEnd}) {
    house.addWall({x, kCorridorNorth}, {x, kNorth}, {});
  }
}

void addDoors(House& house) {
  constexpr double kOpen = std::numbers::pi / 2;
  house.addDoor({kWest, kSouth}, {kWest, kNorth}, kCorridor, 0.0);
  for (const double at : {kBedroomDoor, kBathDoor, kLargeBedroomDoor}) {
    house.addDoor({kWest, kCorridorNorth}, {kEast, kCorridorNorth}, at, kOpen);
  }
  for (const double at : {kKitchenDoor, kStudyDoor, kLivingDoor}) {
    house.addDoor({kWest, kCorridorSouth}, {kEast, kCorridorSouth}, at, -kOpen);
  }
}

void nameRooms(House& house) {
  house.nameRoom("kitchen", {kKitchen}), house.nameRoom("living room", {kLiving}), house.nameRoom("study", {kStudy});
  house.nameRoom("bedroom", {kBedroom}), house.nameRoom("bath", {kBath});
  house.nameRoom("large bedroom", {kLargeBedroom}), house.nameRoom("hallway", {kHallway});
}

void furnishDayRooms(Furnisher& furnish, Dice& dice) {
  furnish.tableWithChairs({{2.2, 0.2}, {4.0, 2.4}}, 0.9, 0.7);
  furnish.againstWall(kKitchen, Indoor::kCounter, counterShapes(dice.between(1.6, 2.2)), 3);
  furnish.againstWall(kKitchen, Indoor::kFridge, fridgeShapes());
  furnish.againstWall(kKitchen, Indoor::kSink, sinkShapes());
  furnish.againstWall(kKitchen, Indoor::kChair, chairShapes(dice));
  furnish.againstWall(kKitchen, Indoor::kBin, wasteBinShapes(dice));

  furnish.tableWithChairs({{5.6, 2.0}, {8.0, kCorridorSouth}}, 1.1, 0.7);
  furnish.againstWall(kLiving, Indoor::kSofa, sofaShapes(dice.between(1.7, 2.2)), 0, 0.3);
  furnish.againstWall(kLiving, Indoor::kShelf, shelfShapes(dice.between(0.9, 1.3), dice.between(1.5, 2.0)));
  furnish.againstWall(kLiving, Indoor::kCabinet, cabinetShapes(dice));
  furnish.againstWall(kLiving, Indoor::kLamp, lampShapes(dice));
  furnish.againstWall(kLiving, Indoor::kPlant, plantShapes(dice));
  furnish.againstWall(kLiving, Indoor::kPlant, plantShapes(dice));
  furnish.hang(kLiving, Indoor::kPicture, pictureShapes(dice.between(0.7, 1.2), 0.6, 1.6));
  furnish.hang(kLiving, Indoor::kPicture, pictureShapes(0.5, 0.5, 1.6));

  furnish.workplace(kStudy);
  furnish.workplace(kStudy);
  furnish.againstWall(kStudy, Indoor::kShelf, shelfShapes(dice.between(0.8, 1.1), 1.9));
  furnish.againstWall(kStudy, Indoor::kBin, wasteBinShapes(dice));
  furnish.againstWall(kStudy, Indoor::kBox, boxShapes(dice));
  furnish.againstWall(kStudy, Indoor::kLamp, lampShapes(dice));
  furnish.hang(kStudy, Indoor::kPicture, pictureShapes(0.6, 0.8, 1.6));
}

void furnishNightRooms(Furnisher& furnish, Dice& dice) {
  furnish.againstWall(kBedroom, Indoor::kBed, bedShapes(0.9), -1, 0.2);
  furnish.againstWall(kBedroom, Indoor::kCabinet, cabinetShapes(dice));
  furnish.againstWall(kBedroom, Indoor::kChair, chairShapes(dice));
  furnish.againstWall(kBedroom, Indoor::kBox, boxShapes(dice));
  furnish.hang(kBedroom, Indoor::kPicture, pictureShapes(0.8, 0.5, 1.6));

  furnish.againstWall(kBath, Indoor::kToilet, toiletShapes());
  furnish.againstWall(kBath, Indoor::kSink, sinkShapes());
  furnish.againstWall(kBath, Indoor::kBin, wasteBinShapes(dice));

  furnish.againstWall(kLargeBedroom, Indoor::kBed, bedShapes(1.5), -1, 0.2);
  furnish.againstWall(kLargeBedroom, Indoor::kCabinet, cabinetShapes(dice));
  furnish.againstWall(kLargeBedroom, Indoor::kCabinet, cabinetShapes(dice));
  furnish.workplace(kLargeBedroom);
  furnish.againstWall(kLargeBedroom, Indoor::kPlant, plantShapes(dice));
  furnish.againstWall(kLargeBedroom, Indoor::kLamp, lampShapes(dice));
  furnish.againstWall(kLargeBedroom, Indoor::kBox, boxShapes(dice));
  furnish.hang(kLargeBedroom, Indoor::kPicture, pictureShapes(1.0, 0.7, 1.7));

  furnish.againstWall(kHallway, Indoor::kCabinet, {block(0, 0, 0, 0.3, 0.7, 0.8)}, 1);
  furnish.hang(kHallway, Indoor::kPicture, pictureShapes(0.6, 0.6, 1.6), 0);
  furnish.hang(kHallway, Indoor::kPicture, pictureShapes(0.5, 0.7, 1.6), 2);
}

}  // namespace

Scene makeApartment(std::uint64_t seed, double dynamics) {
  const Height floor = [](const Vec2& /*p*/) { return 0.0; };
  const Journey travel({tour(), 1.3}, 1.2, 1.8);
  Scene scene;
  scene.label_space = "indoor";
  scene.T_world_body = bodyOn(travel, floor, {.height = kSensorHeight, .sway = 0.012, .bob = 0.01});
  scene.duration = kLaps * travel.lapTime();
  Dice dice(seed, 5);
  Stage stage(scene, floor, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), 0.38);
  const Way pacing({{7.6, 6.8}, {8.6, 9.2}, {12.0, 9.0}, {12.0, 6.9}}, 1.2);
  if (dynamics > 0.0) {
    stage.layout().keepOff(pacing.points(), 0.38);
  }
  House house(stage, dice, kCeiling);
  addWalls(house);
  addDoors(house);
  nameRooms(house);
  Furnisher furnish(stage, dice, dynamics);
  furnishDayRooms(furnish, dice);
  furnishNightRooms(furnish, dice);
  for (int i = 0; i < static_cast<int>(std::lround(2.0 * dynamics)); ++i) {
    stage.send(objectOf(Indoor::kPerson), personShapes(dice, 1.0), Journey(pacing, 0.7, 1.5), 4.0 * i);
  }
  return scene;
}

}  // namespace hgg
