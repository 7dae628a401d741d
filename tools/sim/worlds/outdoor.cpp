#include "sim/worlds/outdoor.h"

namespace hgg {
namespace {

constexpr bool kThing = true, kStuff = false;

WorldObject describe(Outdoor label, const char* name, bool thing, ClassId confused_with) {
  return {.label = static_cast<ClassId>(label),
          .thing = thing,
          .foliage = label == Outdoor::kVegetation,
          .confused_with = confused_with,
          .name = name};
}

ClassId id(Outdoor label) { return static_cast<ClassId>(label); }

void addWheels(Shapes& shapes, double wheelbase, double track) {
  for (const double x : {-0.5 * wheelbase, 0.5 * wheelbase}) {
    for (const double y : {-0.5 * track, 0.5 * track}) {
      shapes.push_back(block(x, y, 0.0, 0.6, 0.2, 0.6));
    }
  }
}

}  // namespace

WorldObject objectOf(Outdoor label) {
  constexpr ClassId kBicyclist = 31;
  switch (label) {
    case Outdoor::kCar:
      return describe(label, "car", kThing, id(Outdoor::kTruck));
    case Outdoor::kBicycle:
      return describe(label, "bicycle", kThing, id(Outdoor::kMotorcycle));
    case Outdoor::kBus:
      return describe(label, "bus", kThing, id(Outdoor::kTruck));
    case Outdoor::kMotorcycle:
      return describe(label, "motorcycle", kThing, id(Outdoor::kBicycle));
    case Outdoor::kOtherVehicle:
      return describe(label, "other-vehicle", kThing, id(Outdoor::kTruck));
    case Outdoor::kTruck:
      return describe(label, "truck", kThing, id(Outdoor::kOtherVehicle));
    case Outdoor::kPerson:
      return describe(label, "person", kThing, kBicyclist);
    case Outdoor::kRoad:
      return describe(label, "road", kStuff, 0);
    case Outdoor::kParking:
      return describe(label, "parking", kStuff, 0);
    case Outdoor::kSidewalk:
      return describe(label, "sidewalk", kStuff, 0);
    case Outdoor::kBuilding:
      return describe(label, "building", kStuff, id(Outdoor::kFence));
    case Outdoor::kFence:
      return describe(label, "fence", kStuff, id(Outdoor::kVegetation));
    case Outdoor::kVegetation:
      return describe(label, "vegetation", kStuff, id(Outdoor::kTerrain));
    case Outdoor::kTrunk:
      return describe(label, "trunk", kThing, id(Outdoor::kPole));
    case Outdoor::kTerrain:
      return describe(label, "terrain", kStuff, 0);
    case Outdoor::kPole:
      return describe(label, "pole", kThing, id(Outdoor::kTrunk));
    case Outdoor::kTrafficSign:
      return describe(label, "traffic-sign", kThing, id(Outdoor::kPole));
    case Outdoor::kBench:
      return describe(label, "bench", kThing, id(Outdoor::kFence));
    case Outdoor::kBin:
      return describe(label, "bin", kThing, id(Outdoor::kPole));
  }
  return {};
}

Shapes carShapes(Dice& dice) {
  const double length = dice.between(3.7, 4.7), width = dice.between(1.68, 1.86), height = dice.between(1.4, 1.6);
  const double waist = 0.55 * height, cabin = height - waist;
  const bool has_boot = dice.chance(0.5);
  const double back = has_boot ? -0.32 * length : -0.46 * length, front = 0.2 * length;
  Shapes shapes{block(0, 0, 0.2, length, width, waist - 0.3),
                block(0, 0, waist - 0.1, 0.96 * length, 0.97 * width, 0.1)};
  // The glass leans in: three steps.
  for (int step = 0; step < 3; ++step) {
    const double lean = 0.07 * length * step;
    shapes.push_back(block(0.5 * (front + back) - 0.3 * lean, 0, waist + step * cabin / 3.0, front - back - 1.4 * lean,
                           (0.94 - 0.06 * step) * width, cabin / 3.0));
  }
  addWheels(shapes, 0.6 * length, width - 0.2);
  return shapes;
}

Shapes vanShapes(Dice& dice) {
  const double length = dice.between(5.0, 5.8), height = dice.between(2.0, 2.5);
  Shapes shapes{block(-0.4, 0, 0.3, length - 0.8, 1.95, height - 0.3),
                block(0.5 * length - 0.5, 0, 0.3, 1.0, 1.9, 0.75),
                block(0.5 * length - 0.75, 0, 1.05, 0.5, 1.8, 0.5 * height - 0.2)};
  addWheels(shapes, 0.6 * length, 1.75);
  return shapes;
}

Shapes busShapes() {
  Shapes shapes{block(0, 0, 0.35, 10.5, 2.45, 0.75), block(0, 0, 1.1, 10.4, 2.4, 1.3),
                block(0, 0, 2.4, 10.2, 2.3, 0.6)};
  addWheels(shapes, 5.8, 2.25);
  return shapes;
}

Shapes caravanShapes() {
  Shapes shapes{block(0, 0, 0.45, 4.6, 2.1, 1.0), block(0, 0, 1.45, 4.3, 2.0, 0.8),
                block(2.8, 0, 0.4, 1.2, 0.15, 0.12)};
  addWheels(shapes, 0.5, 1.95);
  return shapes;
}

Shapes motorcycleShapes() {
  return {block(-0.68, 0, 0.0, 0.62, 0.14, 0.62), block(0.68, 0, 0.0, 0.62, 0.12, 0.62),
          block(-0.05, 0, 0.25, 0.9, 0.3, 0.45),  block(-0.4, 0, 0.7, 0.7, 0.26, 0.12),
          block(0.5, 0, 0.65, 0.12, 0.1, 0.4),    block(0.45, 0, 1.0, 0.08, 0.7, 0.06)};
}

Shapes bicycleShapes() {
  return {block(-0.52, 0, 0.0, 0.64, 0.05, 0.64), block(0.52, 0, 0.0, 0.64, 0.05, 0.64),
          block(0.0, 0, 0.4, 0.9, 0.06, 0.12),    block(-0.2, 0, 0.52, 0.08, 0.06, 0.38),
          block(-0.22, 0, 0.9, 0.28, 0.16, 0.08), block(0.42, 0, 0.6, 0.06, 0.06, 0.4),
          block(0.42, 0, 1.0, 0.08, 0.56, 0.05)};
}

Shapes poleShapes(double height) { return {Cylinder{Vec3::Zero(), 0.09, height}}; }

Shapes lampPostShapes(double height) {
  return {Cylinder{Vec3::Zero(), 0.08, height}, block(0.5, 0, height - 0.1, 1.0, 0.08, 0.08),
          block(1.1, 0, height - 0.15, 0.5, 0.2, 0.12)};
}

Shapes signShapes(Dice& dice) {
  const double height = dice.between(2.0, 2.6), size = dice.between(0.55, 0.8);
  return {Cylinder{Vec3::Zero(), 0.04, height}, block(0.06, 0, height - size, 0.04, size, size)};
}

void putPlate(Stage& stage, Dice& dice, const Spot& spot, double gap) {
  constexpr double kPlate = 0.35, kPoleRadius = 0.03;  // m
  const double top = dice.between(2.1, 2.6);
  if (stage.put(objectOf(Outdoor::kPole), {Cylinder{Vec3::Zero(), kPoleRadius, top}}, spot, gap)) {
    addObject(stage.world(), objectOf(Outdoor::kTrafficSign),
              placed({block(kPoleRadius + 0.02, 0, top - kPlate, 0.03, kPlate, kPlate)}, spot));
  }
}

Shapes benchShapes(double length) {
  const double end = 0.5 * length - 0.2;
  return {block(0, 0, 0.4, 0.45, length, 0.06),     block(-0.22, 0, 0.5, 0.06, length, 0.4),
          block(0, -end, 0.0, 0.4, 0.08, 0.4),      block(0, end, 0.0, 0.4, 0.08, 0.4),
          block(-0.22, -end, 0.4, 0.06, 0.08, 0.4), block(-0.22, end, 0.4, 0.06, 0.08, 0.4)};
}

Shapes binShapes(Dice& dice) {
  const double height = dice.between(0.75, 1.05), radius = dice.between(0.22, 0.3);
  return {Cylinder{Vec3::Zero(), radius, height}, Cylinder{Vec3(0, 0, height), radius + 0.04, 0.06}};
}

Shapes fenceShapes(double length) {
  Shapes shapes{block(0, 0, 0.15, 0.05, length, 1.1)};
  for (double y = -0.5 * length; y <= 0.5 * length + 1e-9; y += 2.0) {
    shapes.push_back(block(0, y, 0.0, 0.1, 0.1, 1.35));
  }
  return shapes;
}

Shapes hedgeShapes(double length, double height) { return {block(0, 0, 0.0, 0.9, length, height)}; }

Shapes houseShapes(Dice& dice, double width, double depth) {
  const double eaves = dice.between(4.5, 7.5), back = -0.5 * depth;
  // Below ground too, so that a slope leaves no gap; a porch or bay breaks the front.
  Shapes shapes{block(back, 0, -1.5, depth, width, eaves + 1.5)};
  for (int step = 0; step < 3; ++step) {
    shapes.push_back(block(back, 0, eaves + 0.8 * step, depth * (0.85 - 0.3 * step), width, 0.8));
  }
  const double bay = dice.between(-0.3, 0.3) * width;
  shapes.push_back(block(0.4, bay, -1.5, 0.8, dice.between(1.6, 2.6), dice.between(3.7, 4.5)));
  return shapes;
}

Shapes bushShapes(double radius) { return {Ellipsoid{Vec3(0, 0, 0.6 * radius), Vec3(radius, radius, 0.8 * radius)}}; }

Tree treeShapes(Dice& dice) {
  const double height = dice.between(2.0, 3.2), radius = dice.between(0.13, 0.28), crown = dice.between(1.3, 2.2);
  const double lean = dice.between(-0.4, 0.4);
  return {{Cylinder{Vec3::Zero(), radius, height + 0.4}},
          {Ellipsoid{Vec3(0, 0, height + 0.8 * crown), Vec3(crown, crown, crown)},
           Ellipsoid{Vec3(lean, -lean, height + 1.5 * crown), 0.75 * Vec3(crown, crown, crown)}}};
}

void putTree(Stage& stage, const Tree& tree, const Spot& spot, double gap) {
  if (stage.put(objectOf(Outdoor::kTrunk), tree.trunk, spot, gap)) {
    addObject(stage.world(), objectOf(Outdoor::kVegetation), placed(tree.crown, spot));
  }
}

}  // namespace hgg
