#pragma once

#include <optional>
#include <vector>

#include "query/scene.h"

namespace hgg {

/// A way somebody may look, and how likely that is. Unit vectors in the plane of the map.
struct Gaze {
  Vec2 direction = Vec2::UnitX();
  double probability = 1;
};

/// What is left of somebody who looks this way.
inline Vec2 leftOf(const Vec2& gaze) { return {-gaze.y(), gaze.x()}; }

/// Where the front of a thing is: its own where it is known, else to where it was seen from, else to the middle of the
/// room.
Vec2 frontOf(const QueryScene& scene, const SceneThing& thing);

/// How people look at things of one kind when they tell them apart by left and right, and do not say how: across the
/// row, from the middle of the room; both ways where the row goes through the middle.
std::vector<Gaze> gazesAt(const QueryScene& scene, const std::vector<int>& things);

}  // namespace hgg
