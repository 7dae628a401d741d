#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "query/referent.h"
#include "query/request.h"
#include "query/scene.h"

namespace hgg {

/// Where who asks stands and looks.
struct Standpoint {
  double x = 0, y = 0, yaw = 0;  // m, rad; map frame where it comes from outside, else that of the scene
};

/// False where a place is none to stand at: it is not finite, or farther from the origin than cells have numbers for.
inline bool isPlace(const Standpoint& p) {
  constexpr double kFarthest = 1e6;  // m
  return std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest && std::isfinite(p.yaw);
}

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
/// How somebody at a standpoint looks at a place.
std::vector<Gaze> gazesFrom(const Standpoint& from, const Vec2& at);
/// How somebody looks who faces what is referred to, or looks at things from there.
std::vector<Gaze> gazesOfView(const QueryScene& scene, View::Kind kind, const Referents& referred,
                              const std::vector<int>& things);
/// How somebody looks at a thing who says what is left of it or in front of it, and does not say from where.
std::vector<Gaze> gazesAtFront(const QueryScene& scene, const SceneThing& thing);
/// The direction that a relation means for each gaze: left of it, behind it and so on.
std::vector<Gaze> directionsOf(Relation relation, std::vector<Gaze> gazes);

/// Where one enters: the doors of the scene, each as likely.
Referents doorsOf(const QueryScene& scene);

/// The middle of some things.
Vec2 middleOf(const QueryScene& scene, const std::vector<int>& things);

}  // namespace hgg
