#include "sim/worlds/indoor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hgg {
namespace {

constexpr bool kThing = true, kStuff = false;
constexpr double kWallThickness = 0.12;
constexpr double kToWall = 0.5 * kWallThickness + 0.04;  // m from a wall's middle to furniture
constexpr double kTableHeight = 0.74;

WorldObject describe(Indoor label, const char* name, bool thing, Indoor confused_with) {
  return {.label = static_cast<ClassId>(label),
          .thing = thing,
          .foliage = label == Indoor::kPlant,
          .confused_with = confused_with == label ? ClassId{0} : static_cast<ClassId>(confused_with),
          .name = name};
}

void addLegs(Shapes& shapes, double length, double width, double height, double thickness) {
  const double x = 0.5 * (length - thickness), y = 0.5 * (width - thickness);
  for (const Vec2& leg : {Vec2(x, y), Vec2(x, -y), Vec2(-x, y), Vec2(-x, -y)}) {
    shapes.push_back(block(leg.x(), leg.y(), 0.0, thickness, thickness, height));
  }
}

bool isLight(Indoor label) {
  return label == Indoor::kChair || label == Indoor::kBin || label == Indoor::kBox || label == Indoor::kPlant;
}

Bounds boundsOf(const Shapes& shapes) {
  Bounds bounds;
  for (const Shape& shape : shapes) {
    bounds = join(bounds, boundsOf(shape));
  }
  return bounds;
}

/// Whether any solid of the world comes within `gap` of the box.
bool isOccupied(const World& world, const Bounds& box, double gap) {
  return std::ranges::any_of(world.solids, [&](const Solid& solid) {
    const Bounds b = boundsOf(solid.shape);
    return ((b.lo - box.hi).array() < gap).all() && ((box.lo - b.hi).array() < gap).all();
  });
}

bool isInWall(const World& world, const Vec3& p) {
  return std::ranges::any_of(world.solids, [&](const Solid& solid) {
    const Bounds b = boundsOf(solid.shape);
    return world.objects[solid.object].label == static_cast<ClassId>(Indoor::kWall) &&
           (p.array() >= b.lo.array()).all() && (p.array() <= b.hi.array()).all();
  });
}

}  // namespace

WorldObject objectOf(Indoor label) {
  switch (label) {
    case Indoor::kWall:
      return describe(label, "wall", kStuff, label);
    case Indoor::kFloor:
      return describe(label, "floor", kStuff, label);
    case Indoor::kCeiling:
      return describe(label, "ceiling", kStuff, label);
    case Indoor::kDoor:
      return describe(label, "door", kThing, Indoor::kCabinet);
    case Indoor::kWindow:
      return describe(label, "window", kThing, Indoor::kPicture);
    case Indoor::kStairs:
      return describe(label, "stairs", kStuff, label);
    case Indoor::kPillar:
      return describe(label, "pillar", kThing, Indoor::kWall);
    case Indoor::kChair:
      return describe(label, "chair", kThing, Indoor::kSofa);
    case Indoor::kTable:
      return describe(label, "table", kThing, Indoor::kDesk);
    case Indoor::kDesk:
      return describe(label, "desk", kThing, Indoor::kTable);
    case Indoor::kSofa:
      return describe(label, "sofa", kThing, Indoor::kBed);
    case Indoor::kBed:
      return describe(label, "bed", kThing, Indoor::kSofa);
    case Indoor::kShelf:
      return describe(label, "shelf", kThing, Indoor::kCabinet);
    case Indoor::kCabinet:
      return describe(label, "cabinet", kThing, Indoor::kShelf);
    case Indoor::kBench:
      return describe(label, "bench", kThing, Indoor::kTable);
    case Indoor::kCounter:
      return describe(label, "counter", kThing, Indoor::kTable);
    case Indoor::kMonitor:
      return describe(label, "monitor", kThing, Indoor::kPicture);
    case Indoor::kLamp:
      return describe(label, "lamp", kThing, Indoor::kPlant);
    case Indoor::kPlant:
      return describe(label, "plant", kThing, Indoor::kBin);
    case Indoor::kBin:
      return describe(label, "bin", kThing, Indoor::kBox);
    case Indoor::kBox:
      return describe(label, "box", kThing, Indoor::kBin);
    case Indoor::kPicture:
      return describe(label, "picture", kThing, Indoor::kWindow);
    case Indoor::kSink:
      return describe(label, "sink", kThing, Indoor::kCounter);
    case Indoor::kToilet:
      return describe(label, "toilet", kThing, Indoor::kChair);
    case Indoor::kFridge:
      return describe(label, "fridge", kThing, Indoor::kCabinet);
    case Indoor::kTicketMachine:
      return describe(label, "ticket-machine", kThing, Indoor::kCabinet);
    case Indoor::kPerson:
      return describe(label, "person", kThing, Indoor::kPillar);
    case Indoor::kSign:
      return describe(label, "sign", kThing, Indoor::kPicture);
  }
  return {};
}

Shapes chairShapes(Dice& dice) {
  const double width = dice.between(0.4, 0.48), seat = dice.between(0.43, 0.48);
  Shapes shapes{block(0, 0, seat, width, width, 0.04), block(-0.5 * width + 0.02, 0, seat + 0.12, 0.04, width, 0.34)};
  addLegs(shapes, width, width, seat, 0.04);
  shapes.push_back(block(-0.5 * width + 0.02, 0.5 * width - 0.02, seat, 0.04, 0.04, 0.2));
  shapes.push_back(block(-0.5 * width + 0.02, -0.5 * width + 0.02, seat, 0.04, 0.04, 0.2));
  return shapes;
}

Shapes officeChairShapes(Dice& dice) {
  const double seat = dice.between(0.44, 0.52);
  return {block(0, 0, seat, 0.48, 0.5, 0.08),    block(-0.22, 0, seat + 0.15, 0.07, 0.44, 0.5),
          block(-0.22, 0, seat, 0.05, 0.1, 0.2), Cylinder{Vec3(0, 0, 0.1), 0.04, seat - 0.1},
          block(0, 0, 0.03, 0.6, 0.07, 0.07),    block(0, 0, 0.03, 0.07, 0.6, 0.07)};
}

Shapes tableShapes(double length, double width) {
  Shapes shapes{block(0, 0, kTableHeight - 0.04, width, length, 0.04)};
  addLegs(shapes, width - 0.1, length - 0.1, kTableHeight - 0.04, 0.06);
  return shapes;
}

Shapes deskShapes(double length) {
  return {block(0, 0, kTableHeight - 0.03, 0.75, length, 0.03),
          block(0, 0.5 * length - 0.02, 0.0, 0.7, 0.04, kTableHeight - 0.03),
          block(0, -0.5 * length + 0.02, 0.0, 0.7, 0.04, kTableHeight - 0.03),
          block(0.05, -0.5 * length + 0.26, 0.08, 0.6, 0.4, 0.55), block(-0.34, 0, 0.3, 0.02, length - 0.1, 0.4)};
}

Shapes monitorShapes(Dice& dice, double z) {
  const double width = dice.between(0.5, 0.7);
  return {block(0, 0, z, 0.18, 0.22, 0.02), block(-0.03, 0, z + 0.02, 0.03, 0.06, 0.2),
          block(0, 0, z + 0.12, 0.04, width, 0.58 * width)};
}

Shapes sofaShapes(double length) {
  const double arm = 0.5 * length - 0.1;
  return {block(0.05, 0, 0.08, 0.75, length - 0.4, 0.36), block(-0.38, 0, 0.08, 0.2, length, 0.75),
          block(0.05, arm, 0.08, 0.75, 0.2, 0.52), block(0.05, -arm, 0.08, 0.75, 0.2, 0.52)};
}

Shapes bedShapes(double width) {
  return {block(0, 0, 0.12, 2.0, width, 0.4), block(-1.03, 0, 0.0, 0.06, width, 0.95),
          block(-0.75, 0.25 * width, 0.52, 0.4, 0.4 * width, 0.12),
          block(-0.75, -0.25 * width, 0.52, 0.4, 0.4 * width, 0.12)};
}

Shapes shelfShapes(double length, double height) {
  Shapes shapes{block(-0.16, 0, 0, 0.02, length, height), block(0, 0.5 * length - 0.015, 0, 0.34, 0.03, height),
                block(0, -0.5 * length + 0.015, 0, 0.34, 0.03, height)};
  for (double z = 0.05; z < height; z += 0.36) {
    shapes.push_back(block(0, 0, z, 0.34, length, 0.03));
  }
  return shapes;
}

Shapes cabinetShapes(Dice& dice) {
  return {block(0, 0, 0, dice.between(0.4, 0.5), dice.between(0.7, 1.1), dice.between(0.9, 1.9))};
}

Shapes indoorBenchShapes(double length) {
  return {block(0, 0, 0.4, 0.42, length, 0.06), block(0, 0.35 * length, 0.0, 0.36, 0.08, 0.4),
          block(0, -0.35 * length, 0.0, 0.36, 0.08, 0.4)};
}

Shapes counterShapes(double length) {
  return {block(0, 0, 0.08, 0.58, length, 0.8), block(0.01, 0, 0.88, 0.62, length, 0.04)};
}

Shapes lampShapes(Dice& dice) {
  const double height = dice.between(1.4, 1.7);
  return {Cylinder{Vec3(0, 0, 0), 0.14, 0.03}, Cylinder{Vec3(0, 0, 0.03), 0.02, height - 0.3},
          Cylinder{Vec3(0, 0, height - 0.28), 0.19, 0.28}};
}

Shapes plantShapes(Dice& dice) {
  const double pot = dice.between(0.25, 0.4), leaves = dice.between(0.25, 0.4);
  return {Cylinder{Vec3(0, 0, 0), 0.17, pot},
          Ellipsoid{Vec3(0, 0, pot + 1.1 * leaves), Vec3(leaves, leaves, 1.3 * leaves)}};
}

Shapes wasteBinShapes(Dice& dice) { return {Cylinder{Vec3::Zero(), dice.between(0.13, 0.18), dice.between(0.3, 0.5)}}; }

Shapes boxShapes(Dice& dice) {
  return {block(0, 0, 0, dice.between(0.3, 0.5), dice.between(0.35, 0.6), dice.between(0.25, 0.5))};
}

Shapes pictureShapes(double length, double height, double z) {
  return {block(0, 0, z - 0.5 * height, 0.03, length, height)};
}

Shapes sinkShapes() {
  return {block(0, 0, 0.72, 0.45, 0.55, 0.16), Cylinder{Vec3(-0.05, 0, 0), 0.08, 0.72},
          block(-0.18, 0, 0.88, 0.04, 0.05, 0.18)};
}

Shapes toiletShapes() {
  return {Cylinder{Vec3(0.08, 0, 0.0), 0.19, 0.4}, block(-0.25, 0, 0.35, 0.18, 0.38, 0.42),
          block(-0.12, 0, 0.0, 0.3, 0.24, 0.4)};
}

Shapes fridgeShapes() { return {block(0, 0, 0.02, 0.62, 0.6, 1.78), block(0.33, 0.24, 0.9, 0.04, 0.03, 0.5)}; }

Shapes ticketMachineShapes() {
  return {block(0, 0, 0, 0.6, 0.8, 1.2), block(-0.08, 0, 1.2, 0.44, 0.8, 0.6), block(0.3, 0, 0.95, 0.14, 0.6, 0.06)};
}

Shapes standeeShapes(Dice& dice) {
  return {Cylinder{Vec3::Zero(), 0.2, 0.03}, Cylinder{Vec3(0, 0, 0.03), 0.03, 1.3},
          block(0, 0, 1.1, 0.03, dice.between(0.45, 0.6), 0.7)};
}

Opening doorway(double at) { return {at, 1.0, 0.0, 2.1}; }
Opening windowAt(double at, double width) { return {at, width, 0.9, 2.1}; }

void House::addFloor(const Vec2& lo, const Vec2& hi) {
  const Vec2 center = 0.5 * (lo + hi), size = hi - lo;
  const Spot middle = stage_.spot(center, 0.0);
  addObject(stage_.world(), objectOf(Indoor::kFloor), placed({block(0, 0, -0.1, size.x(), size.y(), 0.1)}, middle));
  addObject(stage_.world(), objectOf(Indoor::kCeiling),
            placed({block(0, 0, ceiling_, size.x(), size.y(), 0.1)}, middle));
}

void House::nameRoom(const std::string& name, const std::vector<Room>& parts) {
  TruthRoom room{name};
  for (const Room& part : parts) {
    room.parts.emplace_back(Vec3(part.lo.x(), part.lo.y(), 0.0), Vec3(part.hi.x(), part.hi.y(), ceiling_));
  }
  stage_.addRoom(std::move(room));
}

void House::addWall(const Vec2& from, const Vec2& to, std::vector<Opening> openings) {
  const Vec2 along = (to - from).normalized();
  const double length = (to - from).norm();
  const Spot start = stage_.spot(from, std::atan2(along.y(), along.x()));
  Shapes wall;
  const auto piece = [&](double begin, double end, double bottom, double top) {
    if (end > begin && top > bottom) {
      wall.push_back(block(0.5 * (begin + end), 0, bottom, end - begin, kWallThickness, top - bottom));
    }
  };
  std::ranges::sort(openings, {}, &Opening::at);
  double done = -0.5 * kWallThickness;
  for (const Opening& opening : openings) {
    const double begin = opening.at - 0.5 * opening.width, end = opening.at + 0.5 * opening.width;
    piece(done, begin, 0.0, ceiling_);
    piece(begin, end, 0.0, opening.bottom);
    piece(begin, end, opening.top, ceiling_);
    done = end;
    if (opening.bottom == 0.0) {
      // One may walk through: nothing is put in front of it.
      stage_.layout().claim(footprintOf({block(opening.at, 0, 0, opening.width, 1.4, 1.0)}, start));
    } else {
      const Shapes pane{block(opening.at, 0, opening.bottom, opening.width, 0.04, opening.top - opening.bottom)};
      addObject(stage_.world(), objectOf(Indoor::kWindow), placed(pane, start));
    }
  }
  piece(done, length + 0.5 * kWallThickness, 0.0, ceiling_);
  addObject(stage_.world(), objectOf(Indoor::kWall), placed(wall, start));
}

void House::addDoor(const Vec2& from, const Vec2& to, double at, double angle) {
  constexpr double kLeaf = 0.9, kThick = 0.045, kHigh = 2.05;
  const Vec2 along = (to - from).normalized();
  const Vec2 hinge = from + (at - 0.5 * kLeaf) * along;
  const Spot spot = stage_.spot(hinge, std::atan2(along.y(), along.x()) + angle + dice_.between(-0.05, 0.05));
  const Shapes leaf{block(0.5 * kLeaf, 0, 0.01, kLeaf, kThick, kHigh), block(kLeaf - 0.08, 0, 1.0, 0.1, 0.15, 0.03)};
  stage_.layout().claim(footprintOf(leaf, spot));
  addObject(stage_.world(), objectOf(Indoor::kDoor), placed(leaf, spot));
}

bool Furnisher::put(Indoor label, const Shapes& shapes, const Spot& spot, double gap) {
  const auto object = stage_.put(objectOf(label), shapes, spot, gap);
  if (object && isLight(label) && dice_.chance(0.4 * dynamics_)) {
    mayBeMoved(*object, shapes, spot);
  }
  return object.has_value();
}

void Furnisher::mayBeMoved(std::size_t object, const Shapes& shapes, const Spot& spot) {
  constexpr int kTries = 10;
  constexpr double kGap = 0.1;
  stage_.takeAway(object);
  for (int i = 0; i < kTries && dice_.chance(0.9); ++i) {
    const Vec2 aside(dice_.between(-1.2, 1.2), dice_.between(-1.2, 1.2));
    const Spot new_spot = stage_.spot(spot.ground.head<2>() + aside, spot.yaw + dice_.between(-0.8, 0.8));
    const bool through_wall = isOccupied(stage_.world(), boundsOf(placed(shapes, new_spot)), -0.02);
    const auto moved = through_wall ? std::nullopt : stage_.put(stage_.world().objects[object], shapes, new_spot, kGap);
    if (moved) {
      stage_.bring(*moved);
      return;
    }
  }
}

bool Furnisher::fits(const Room& room, const Shapes& shapes, const Spot& spot) const {
  const Footprint f = footprintOf(shapes, spot);
  const double c = std::abs(std::cos(f.yaw)), s = std::abs(std::sin(f.yaw));
  const Vec2 reach(c * f.half.x() + s * f.half.y(), s * f.half.x() + c * f.half.y());
  const Vec2 inset = Vec2::Constant(kToWall - 0.005);
  return ((f.center - reach - room.lo - inset).array() >= 0.0).all() &&
         ((room.hi - inset - f.center - reach).array() >= 0.0).all();
}

Spot Furnisher::atWall(const Room& room, const Shapes& shapes, int wall) {
  const Footprint f = footprintOf(shapes, {Vec3::Zero(), 0.0});
  const double back = f.half.x() - f.center.x() + kToWall;  // from the wall to the local origin
  const Vec2 free = (room.hi - room.lo) / 2.0 - Vec2::Constant(f.half.y() + kToWall);
  const Vec2 slide = room.center() + Vec2(dice_.between(-1.0, 1.0) * free.x(), dice_.between(-1.0, 1.0) * free.y());
  switch (wall) {
    case 0:
      return stage_.spot({slide.x(), room.lo.y() + back}, std::numbers::pi / 2);
    case 1:
      return stage_.spot({room.hi.x() - back, slide.y()}, std::numbers::pi);
    case 2:
      return stage_.spot({slide.x(), room.hi.y() - back}, -std::numbers::pi / 2);
    default:
      return stage_.spot({room.lo.x() + back, slide.y()}, 0.0);
  }
}

std::optional<Spot> Furnisher::againstWall(const Room& room, Indoor label, const Shapes& shapes, int wall, double gap) {
  constexpr int kTries = 40;
  for (int i = 0; i < kTries; ++i) {
    const Spot spot = atWall(room, shapes, wall >= 0 ? wall : static_cast<int>(dice_.below(4)));
    if (fits(room, shapes, spot) && put(label, shapes, spot, gap)) {
      return spot;
    }
  }
  return std::nullopt;
}

std::optional<Spot> Furnisher::inside(const Room& room, Indoor label, const Shapes& shapes, double gap) {
  constexpr int kTries = 40;
  for (int i = 0; i < kTries; ++i) {
    const Vec2 p(dice_.between(room.lo.x(), room.hi.x()), dice_.between(room.lo.y(), room.hi.y()));
    const Spot spot = stage_.spot(p, (dice_.chance(0.5) ? 0.0 : std::numbers::pi / 2) + dice_.between(-0.1, 0.1));
    if (fits(room, shapes, spot) && put(label, shapes, spot, gap)) {
      return spot;
    }
  }
  return std::nullopt;
}

void Furnisher::hang(const Room& room, Indoor label, const Shapes& shapes, int wall) {
  constexpr int kTries = 30;
  constexpr double kGap = 0.03, kBehind = 0.1;
  const Bounds local = boundsOf(shapes);
  for (int i = 0; i < kTries; ++i) {
    const Spot spot = atWall(room, shapes, wall >= 0 ? wall : static_cast<int>(dice_.below(4)));
    const Pose T_world_local = poseOf(spot);
    const auto wallBehind = [&](double y, double z) {
      return isInWall(stage_.world(), T_world_local * Vec3(local.lo.x() - kBehind, y, z));
    };
    const bool on_wall = wallBehind(local.lo.y(), local.lo.z()) && wallBehind(local.hi.y(), local.lo.z()) &&
                         wallBehind(local.lo.y(), local.hi.z()) && wallBehind(local.hi.y(), local.hi.z());
    if (on_wall && !isOccupied(stage_.world(), boundsOf(placed(shapes, spot)), kGap)) {
      addObject(stage_.world(), objectOf(label), placed(shapes, spot));
      return;
    }
  }
}

void Furnisher::tableWithChairs(const Room& room, double length, double width) {
  constexpr double kSeat = 0.6;  // m of table a chair needs
  const auto table = inside(room, Indoor::kTable, tableShapes(length, width), 0.5);
  if (!table) {
    return;
  }
  const Pose T_world_table = poseOf(*table);
  for (const double side : {-1.0, 1.0}) {
    const int seats = static_cast<int>(length / kSeat / 1.2);
    for (int i = 0; i < seats; ++i) {
      const double y = (i + 0.5 - 0.5 * seats) * (length / seats) + dice_.between(-0.05, 0.05);
      const Vec3 at = T_world_table * Vec3(side * (0.5 * width + dice_.between(0.4, 0.55)), y, 0.0);
      const double yaw = table->yaw + (side > 0 ? std::numbers::pi : 0.0) + dice_.between(-0.15, 0.15);
      const Spot spot{at, yaw};
      const Shapes chair = chairShapes(dice_);
      if (dice_.chance(0.85) && fits(room, chair, spot)) {
        put(Indoor::kChair, chair, spot, 0.13);
      }
    }
  }
}

void Furnisher::workplace(const Room& room) {
  const double length = dice_.between(1.3, 1.7);
  const auto desk = againstWall(room, Indoor::kDesk, deskShapes(length), -1, 0.3);
  if (!desk) {
    return;
  }
  const Pose T_world_desk = poseOf(*desk);
  const Spot screen{T_world_desk * Vec3(-0.15, dice_.between(-0.2, 0.2), 0.0), desk->yaw + dice_.between(-0.2, 0.2)};
  addObject(stage_.world(), objectOf(Indoor::kMonitor), placed(monitorShapes(dice_, kTableHeight), screen));
  const Spot seat{T_world_desk * Vec3(dice_.between(0.75, 0.95), dice_.between(-0.2, 0.3), 0.0),
                  desk->yaw + std::numbers::pi + dice_.between(-0.5, 0.5)};
  put(Indoor::kChair, officeChairShapes(dice_), seat, 0.13);
}

}  // namespace hgg
