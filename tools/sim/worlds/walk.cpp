#include "sim/worlds/grounds.h"

namespace hgg {
namespace {

constexpr double kPole = 0.05;      // m, diameter
constexpr double kDoorway = 0.9;    // m
constexpr double kNarrowGap = 0.4;  // m: too narrow for the body

/// A table too low to walk below it.
Shapes lowTableShapes() {
  constexpr double kLength = 1.6, kWidth = 0.9, kHeight = 0.5, kTop = 0.04, kLeg = 0.05;
  Shapes shapes{block(0, 0, kHeight - kTop, kLength, kWidth, kTop)};
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      shapes.push_back(block(x * (kLength - kLeg), y * (kWidth - kLeg), 0.0, kLeg, kLeg, kHeight - kTop));
    }
  }
  return shapes;
}

/// A wall with a doorway in it across the way, and one with a narrow gap beside the way.
void addWalls(World& world, double x, double y0, double y1, double door, double gap_x) {
  constexpr double kThickness = 0.12, kHeight = 2.4, kTop = 2.0;
  const double south = door - 0.5 * kDoorway, north = door + 0.5 * kDoorway;
  addObject(world, objectOf(Indoor::kWall),
            {block(x, 0.5 * (y0 + south), 0.0, kThickness, south - y0, kHeight),
             block(x, 0.5 * (north + y1), 0.0, kThickness, y1 - north, kHeight),
             block(x, door, kTop, kThickness, kDoorway, kHeight - kTop)});
  constexpr double kLength = 1.2, kWallY = 6.0;
  for (const double side : {-1.0, 1.0}) {
    addObject(world, objectOf(Indoor::kWall),
              {block(gap_x + side * 0.5 * (kLength + kNarrowGap), kWallY, 0.0, kLength, kThickness, 1.2)});
  }
}

}  // namespace

Scene makeWalk(std::uint64_t seed) {
  const Hall hall{{0.0, 0.0}, {22.0, 12.0}};
  constexpr double kSouth = 2.2, kNorth = 9.8, kField = 6.0;  // y, of the way's sides and between them
  const std::vector<Vec2> corners{{11.0, kSouth}, {20.0, kSouth}, {20.0, kNorth}, {2.0, kNorth}, {2.0, kSouth}};
  const Footprint field{{11.0, kField}, {7.5, 2.6}, 0.0};
  Scene scene = makeHallScene(
      hall, corners, [](double /*s*/) { return 0.0; }, {field}, seed);
  World& world = scene.world;
  Dice dice(seed, 10);
  const auto about = [&](double x) { return x + dice.between(-0.2, 0.2); };
  addBlocks(world, objectOf(Indoor::kFloor), {hall.lo.x(), hall.hi.x()}, {hall.lo.y(), hall.hi.y()},
            [](const Vec2& /*p*/) { return 0.0; });
  const auto put = [&](Indoor label, const Shapes& shapes, double x, double y, double yaw) {
    addObject(world, objectOf(label), placed(shapes, {Vec3(about(x), about(y), 0.0), yaw}));
  };
  put(Indoor::kFloor, {block(0, 0, 0, 1.6, 1.6, 0.12)}, 5.0, 7.2, 0.0);  // a kerb to step on
  put(Indoor::kFloor, {block(0, 0, 0, 1.6, 1.6, 0.30)}, 5.0, 4.6, 0.0);  // and one that is too high
  put(Indoor::kTable, lowTableShapes(), 8.0, 7.0, 0.0);
  put(Indoor::kChair, chairShapes(dice), 7.6, 4.9, dice.between(0.0, 6.0));
  put(Indoor::kChair, chairShapes(dice), 8.9, 4.5, dice.between(0.0, 6.0));
  put(Indoor::kSign, {block(0, 0, 0.5, 1.0, 1.0, 0.3)}, 15.6, 7.2, 0.0);     // hangs too low
  put(Indoor::kPicture, {block(0, 0, 1.0, 1.0, 1.0, 0.3)}, 15.6, 4.8, 0.0);  // high enough
  for (const double x : {17.2, 17.9}) {
    put(Indoor::kPillar, {Cylinder{Vec3::Zero(), 0.5 * kPole, 1.5}}, x, 6.0, 0.0);
  }
  addWalls(world, about(11.0), 0.0, 4.6, kSouth, about(12.6));
  return scene;
}

}  // namespace hgg
