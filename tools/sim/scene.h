#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/world.h"
#include "truth/rooms.h"

namespace hgg {

/// How an object of the world leaves the place where it was added.
struct Motion {
  std::size_t object = 0;  // index into World::objects
  /// Carries the object's solids from where they were added; nullopt: it is not there (not yet, or no more).
  std::function<std::optional<Pose>(double time)> T_world_object;
};

/// The stretch of the log, s, in which something carries the body from one place to another; it senses nothing.
struct Carried {
  double from = 0, until = 0;
};

/// A world and the way a sensor takes through it. Times are in seconds from the start.
struct Scene {
  World world;
  /// Body x forward, z up. For any time, also shortly before 0: the first frame's LiDAR sweep begins before it.
  std::function<Pose(double time)> T_world_body;
  std::vector<Motion> motions = {};           // at most one an object; all other objects stay
  double duration = 0;                        // s, a whole tour: every loop closed, every change between laps seen
  std::string label_space = "semantickitti";  // or "indoor": the folder of classes.toml in firmware_cfg
  /// A real front-end's poses of the same way (same start pose); empty: odometry is the truth, disturbed.
  std::function<Pose(double time)> T_odom_body = nullptr;
  std::optional<Carried> carried = std::nullopt;
  std::vector<TruthRoom> rooms = {};  // of a building
};

/// Names makeScene() knows.
std::vector<std::string> sceneNames();
/// nullopt when there is no world of that name. The seed varies the placement of objects. `dynamics` 0..1 (share of the
/// most the world has) adds people and cars that move, and objects that are moved or taken away between two laps.
/// `plates`: small signs on poles as well, where hasPlates(); all else stays as it is without.
std::optional<Scene> makeScene(const std::string& name, std::uint64_t seed, double dynamics = 0.0, bool plates = false);
/// Worlds that can have small signs on poles.
bool hasPlates(const std::string& name);

/// A street laid along a way that was really driven, with the poses of a real front-end beside it (both KITTI: camera
/// convention, 3x4 rows read with readPoses(), 10 Hz, the same number). The map frame is body-like: x forward, z up.
Scene pathScene(const std::vector<Pose>& T_world_camera, const std::vector<Pose>& T_odom_camera, std::uint64_t seed,
                double dynamics = 0.0);

/// "yard": a house and trees inside a loop road, parked cars, bicycles, poles, signs, trees and houses around it. One
/// lap of the oval takes 20 s, at 3 to 5 m/s.
Scene makeYard(std::uint64_t seed);
/// "street": a road around a block of houses, twice, up and down a slope. Parked cars in rows, poles, signs, trees,
/// fences, hedges. A lap takes 41 s.
Scene makeStreet(std::uint64_t seed, double dynamics, bool plates = false);
/// "passes": a road of 300 m, out, back on the other lane, and out again. Parked cars in rows and a car park, plates on
/// poles, trees, houses. In traffic (`dynamics`), with cars that park and leave between the passes. 130 s.
Scene makePasses(std::uint64_t seed, double dynamics);
/// "campus": paths between lawns and halls; benches, bins, bicycles, trees, lamps. At walking speed, a lap in under 60
/// s.
Scene makeCampus(std::uint64_t seed, double dynamics, bool plates = false);
/// "apartment": rooms off a corridor, furnished.
Scene makeApartment(std::uint64_t seed, double dynamics);
/// "office": a ring corridor with office rooms, desks, monitors, chairs, shelves.
Scene makeOffice(std::uint64_t seed, double dynamics);
/// "hall": a subway-like hall: rows of identical columns, benches, ticket machines.
Scene makeHall(std::uint64_t seed, double dynamics);
/// "corridor": a long corridor between eight bedrooms; along it, into two of them, and back. One lap.
Scene makeCorridor(std::uint64_t seed, double dynamics);

/// Halls for a robot on legs, whose ground is what is to be found out about; nothing in them moves.
/// "stairs": up a flight of stairs onto a platform without rails and down a ramp.
Scene makeStairs(std::uint64_t seed);
/// "ramp": over ridges of 12 and 25 degrees, past one of 40 that is too steep.
Scene makeRamp(std::uint64_t seed);
/// "hole": around a pit, a trench and a dock that drops by half a metre.
Scene makeHole(std::uint64_t seed);
/// "bridge": below a bridge and over it.
Scene makeBridge(std::uint64_t seed);
/// "walk": around what is in a robot's way: kerbs of 12 and 30 cm, a table, chairs, a plate that hangs at 0.5 m and one
/// at 1 m, a doorway of 0.9 m, poles of 5 cm, a gap of 0.4 m.
Scene makeWalk(std::uint64_t seed);

}  // namespace hgg
