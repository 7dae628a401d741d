#pragma once

#include "sim/worlds/indoor.h"

namespace hgg {

/// A hall whose ground is built of blocks, in which a robot on legs walks laps.
struct Hall {
  Vec2 lo, hi;
  double ceiling = 5.0;
};

/// The way, the walls and what stands along them. Furniture keeps off the way and off `grounds`; the floor is the
/// caller's. `ground`: m above the scene's zero, by the way come so far.
Scene makeHallScene(const Hall& hall, const std::vector<Vec2>& corners, const std::function<double(double s)>& ground,
                    const std::vector<Footprint>& grounds, std::uint64_t seed);
/// The way that makeHallScene() takes through these corners.
Journey hallTravel(const std::vector<Vec2>& corners);

/// The ground as upright blocks between grid lines, each as high as `height` says for its middle. Where it drops, the
/// blocks' sides are walls.
void addBlocks(World& world, const WorldObject& object, const std::vector<double>& xs, const std::vector<double>& ys,
               const Height& height);

/// A ramp from `foot` up to `head` (middles of its ends), `width` m wide: a slab.
Box rampBox(const Vec3& foot, const Vec3& head, double width);

}  // namespace hgg
