#include "sim/worlds/grounds.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

constexpr double kSensorHeight = 0.65;
constexpr double kSpeed = 1.1, kTurnRate = 1.6;  // m/s, rad/s
constexpr double kRounding = 1.8;
constexpr double kLaps = 2.05;
constexpr double kBodyClearance = 0.55;  // m between the way and furniture

}  // namespace

Journey hallTravel(const std::vector<Vec2>& corners) { return {{corners, kRounding}, kSpeed, kTurnRate}; }

Scene makeHallScene(const Hall& hall, const std::vector<Vec2>& corners, const std::function<double(double s)>& ground,
                    const std::vector<Footprint>& grounds, std::uint64_t seed) {
  const Journey travel = hallTravel(corners);
  Scene scene;
  scene.label_space = "indoor";
  scene.T_world_body = bodyAlong(travel, ground, {.height = kSensorHeight, .sway = 0.012, .bob = 0.01});
  scene.duration = kLaps * travel.lapTime();
  Dice dice(seed, 9);
  Stage stage(
      scene, [](const Vec2& /*p*/) { return 0.0; }, travel.lapTime());
  stage.layout().keepOff(travel.way().points(), kBodyClearance);
  for (const Footprint& footprint : grounds) {
    stage.layout().claim(footprint);
  }
  House house(stage, dice, hall.ceiling);
  const Vec2 corner[] = {hall.lo, {hall.hi.x(), hall.lo.y()}, hall.hi, {hall.lo.x(), hall.hi.y()}};
  for (std::size_t i = 0; i < 4; ++i) {
    house.addWall(corner[i], corner[(i + 1) % 4], {});
  }
  const Vec2 size = hall.hi - hall.lo, middle = 0.5 * (hall.lo + hall.hi);
  addObject(scene.world, objectOf(Indoor::kCeiling),
            {block(middle.x(), middle.y(), hall.ceiling, size.x(), size.y(), 0.1)});
  Furnisher furnish(stage, dice, 0.0);
  const Room room{hall.lo, hall.hi};
  for (int wall = 0; wall < 4; ++wall) {
    furnish.againstWall(room, Indoor::kCabinet, cabinetShapes(dice), wall);
    furnish.againstWall(room, Indoor::kBox, boxShapes(dice), wall);
    furnish.againstWall(room, Indoor::kPlant, plantShapes(dice), wall);
    furnish.againstWall(room, Indoor::kBench, indoorBenchShapes(dice.between(1.0, 1.5)), wall);
    for (int i = 0; i < 3; ++i) {
      furnish.hang(room, Indoor::kPicture, pictureShapes(dice.between(0.5, 1.2), dice.between(0.5, 0.8), 1.6), wall);
    }
  }
  return scene;
}

void addBlocks(World& world, const WorldObject& object, const std::vector<double>& xs, const std::vector<double>& ys,
               const Height& height) {
  constexpr double kBottom = -2.0;  // m, below every ground
  const std::size_t index = addObject(world, object, {});
  for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
    for (std::size_t j = 0; j + 1 < ys.size(); ++j) {
      const Vec2 middle(0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1]));
      addSolid(world, index,
               block(middle.x(), middle.y(), kBottom, xs[i + 1] - xs[i], ys[j + 1] - ys[j], height(middle) - kBottom));
    }
  }
}

Box rampBox(const Vec3& foot, const Vec3& head, double width) {
  constexpr double kThickness = 0.1;
  const Vec3 along = head - foot;
  const Vec3 x = along.normalized(), y = Vec3::UnitZ().cross(x).normalized(), z = x.cross(y);
  Box box;
  box.half = 0.5 * Vec3(along.norm(), width, kThickness);
  box.T_world_box = Pose::Identity();
  box.T_world_box.linear() << x, y, z;
  box.T_world_box.translation() = 0.5 * (foot + head) - 0.5 * kThickness * z;
  return box;
}

}  // namespace hgg
