#pragma once

#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "sim/random.h"
#include "sim/scene.h"
#include "sim/worlds/way.h"

namespace hgg {

using Shapes = std::vector<Shape>;

/// A spot on the ground and the heading of what stands there.
struct Spot {
  Vec3 ground;
  double yaw;
};
Pose poseOf(const Spot& spot);
/// Local shapes (origin on the ground, x ahead) moved to a spot. Ellipsoids stay upright and are taken to be round.
Shapes placed(const Shapes& local, const Spot& spot);
Shapes moved(const Shapes& local, const Pose& T_world_local);
/// An upright box in local coordinates: centre of its underside, size.
Box block(double x, double y, double z, double length, double width, double height);

/// Numbers of a seed, one after another.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t stream) : key_{seed, stream} {}
  double between(double lo, double hi) { return lo + (hi - lo) * uniform(key_, counter_++); }
  bool chance(double p) { return uniform(key_, counter_++) < p; }
  std::size_t below(std::size_t n) {
    return static_cast<std::size_t>(uniform(key_, counter_++) * static_cast<double>(n));
  }

 private:
  RandomKey key_;
  std::uint64_t counter_ = 0;
};

/// `stride`: 0 standing, 1 walking.
Shapes personShapes(Dice& dice, double stride);

/// A rectangle on the ground.
struct Footprint {
  Vec2 center, half;
  double yaw;
};
/// The rectangle below the shapes; what is high overhead casts none.
Footprint footprintOf(const Shapes& local, const Spot& spot);
/// At most the true distance of two rectangles, and 0 when they overlap (the widest gap between parallel lines).
double gapBetween(const Footprint& a, const Footprint& b);
double distanceTo(const Footprint& a, const Vec2& p);

/// What is taken: things that stand, and the ways that are driven.
class Layout {
 public:
  /// Nothing is put closer than `clearance` m to these points.
  void keepOff(const std::vector<Vec2>& points, double clearance);
  /// True when the rectangle is `gap` m from all that stands, and off the ways.
  bool isFree(const Footprint& footprint, double gap) const;
  void claim(const Footprint& footprint) { taken_.push_back(footprint); }

 private:
  std::vector<Footprint> taken_;
  double clearance_ = 0;
  std::unordered_map<std::int64_t, std::vector<Vec2>> ways_;  // by grid cell
};

/// The height of the ground.
using Height = std::function<double(const Vec2& p)>;

/// Ground made of triangles between grid lines; each cell belongs to the object that `object_of` names for its centre
/// (none: a hole).
void addGround(World& world, const std::vector<double>& xs, const std::vector<double>& ys, const Height& height,
               const std::function<std::optional<std::size_t>(const Vec2& center)>& object_of);
/// Grid lines through all of `stops` (ascending), at most `widest` apart.
std::vector<double> gridLines(const std::vector<double>& stops, double widest);

/// The body on its way: over the ground at `height`, leaning with the slope, swaying by `sway` rad and bobbing.
struct Gait {
  double height;
  double sway = 0.006;
  double bob = 0.01;
};
std::function<Pose(double)> bodyOn(const Journey& travel, const Height& ground, const Gait& gait);
/// The same where the ground depends on how far the way has come: a way that crosses itself on a bridge.
std::function<Pose(double)> bodyAlong(const Journey& travel, const std::function<double(double s)>& ground,
                                      const Gait& gait);

/// A scene under construction: puts things where there is room. Keeps a reference to the scene.
class Stage {
 public:
  Stage(Scene& scene, Height ground, double lap_time)
      : scene_(scene), ground_(std::move(ground)), lap_time_(lap_time) {}

  Layout& layout() { return layout_; }
  World& world() { return scene_.world; }
  void addRoom(TruthRoom room) { scene_.rooms.push_back(std::move(room)); }
  Spot spot(const Vec2& p, double yaw) const { return {Vec3(p.x(), p.y(), ground_(p)), yaw}; }

  /// Index of the new object; nullopt when there is no room (`gap` m to all that stands).
  std::optional<std::size_t> put(const WorldObject& object, const Shapes& local, const Spot& spot, double gap);
  /// An object that moves by itself along a way, `start` m ahead of its start, or farther where it would run into the
  /// sensor (whose way and duration are set); not at all where it always would.
  void send(WorldObject object, const Shapes& local, const Journey& travel, double start);
  /// The object is there until, or from, a time.
  void takeAway(std::size_t object, double time);
  void bring(std::size_t object, double time);
  /// Both unseen, between the first two laps: after the sensor was nearest in the first, when it is farthest away.
  void takeAway(std::size_t object) { takeAway(object, changeTime(object)); }
  void bring(std::size_t object) { bring(object, changeTime(object)); }

 private:
  double changeTime(std::size_t object) const;
  bool keepsClear(const Shapes& local, const Journey& travel, double start_time) const;
  void addMover(WorldObject object, const Shapes& local, const Journey& travel, double start_time);

  Scene& scene_;
  Height ground_;
  double lap_time_;
  Layout layout_;
};

}  // namespace hgg
