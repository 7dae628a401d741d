#pragma once

#include "sim/worlds/stage.h"

namespace hgg {

/// SemanticKITTI label ids, and the street furniture it lacks (firmware_cfg/semantickitti/classes.toml).
enum class Outdoor : ClassId {
  kCar = 10,
  kBicycle = 11,
  kBus = 13,
  kMotorcycle = 15,
  kTruck = 18,
  kOtherVehicle = 20,
  kPerson = 30,
  kRoad = 40,
  kParking = 44,
  kSidewalk = 48,
  kBuilding = 50,
  kFence = 51,
  kVegetation = 70,
  kTrunk = 71,
  kTerrain = 72,
  kPole = 80,
  kTrafficSign = 81,
  kBench = 260,
  kBin = 261
};

/// What is to be known of an object of the class.
WorldObject objectOf(Outdoor label);

/// Local shapes: origin on the ground, x ahead. The dice vary sizes.
Shapes carShapes(Dice& dice);
Shapes vanShapes(Dice& dice);
Shapes busShapes();
/// A caravan, parked without a car.
Shapes caravanShapes();
Shapes bicycleShapes();
Shapes motorcycleShapes();
Shapes poleShapes(double height);
/// A lamp post: a pole with an arm and a head over the road (+x).
Shapes lampPostShapes(double height);
/// A plate on a post, facing +x.
Shapes signShapes(Dice& dice);
/// Puts a pole and, on it, a plate of 0.35 m (a traffic sign of its own) facing the spot's +x where the pole has room.
void putPlate(Stage& stage, Dice& dice, const Spot& spot, double gap);
Shapes benchShapes(double length);
Shapes binShapes(Dice& dice);
Shapes fenceShapes(double length);
Shapes hedgeShapes(double length, double height);
/// Walls, and a roof that steps in; front towards +x.
Shapes houseShapes(Dice& dice, double width, double depth);
Shapes bushShapes(double radius);

struct Tree {
  Shapes trunk, crown;
};
Tree treeShapes(Dice& dice);
/// Puts the trunk (a thing) and, over it, the crown (stuff) where the trunk has room.
void putTree(Stage& stage, const Tree& tree, const Spot& spot, double gap);

}  // namespace hgg
