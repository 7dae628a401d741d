#include "query/views.h"

#include <cmath>

namespace hgg {
namespace {

/// How sure people are to mean the front as it is taken here, and not the other side.
constexpr double kOwnFront = 0.8;
/// How sure they are to look where the thing they stand at is turned to, and not at what they speak of.
constexpr double kLooksAhead = 0.4;

}  // namespace

Vec2 frontOf(const QueryScene& scene, const SceneThing& thing) {
  if (thing.front) {
    return *thing.front;
  }
  if (thing.seen_from) {
    return *thing.seen_from;
  }
  const Vec2 towards = scene.middle - thing.centre.head<2>();
  // Things stand along walls: the front is across the longer side.
  if (thing.half.x() > 1.5 * thing.half.y()) {
    return {0, towards.y() < 0 ? -1.0 : 1.0};
  }
  if (thing.half.y() > 1.5 * thing.half.x()) {
    return {towards.x() < 0 ? -1.0 : 1.0, 0};
  }
  return towards.norm() > 1e-6 ? Vec2(towards.normalized()) : Vec2(1, 0);
}

std::vector<Gaze> gazesAt(const QueryScene& scene, const std::vector<int>& things) {
  const Vec2 mean = middleOf(scene, things);
  Vec2 fronts = Vec2::Zero();
  for (const int k : things) {
    const SceneThing& thing = scene.things[static_cast<std::size_t>(k)];
    fronts += frontOf(scene, thing) / static_cast<double>(things.size());
  }
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const int k : things) {
    const Vec2 d = scene.things[static_cast<std::size_t>(k)].centre.head<2>() - mean;
    spread += d * d.transpose();
  }
  // The axis of the row, in closed form.
  const double angle = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
  const Vec2 across(-std::sin(angle), std::cos(angle));
  const double side = (mean - scene.middle).dot(across) - 0.5 * fronts.dot(across);
  const double forward = 1 / (1 + std::exp(-2 * side));
  return {{across, forward}, {-across, 1 - forward}};
}

std::vector<Gaze> gazesFrom(const Standpoint& from, const Vec2& at) {
  const Vec2 towards = at - Vec2(from.x, from.y);
  constexpr double kHere = 0.1;  // m: what is so near is looked at by looking ahead
  return {{towards.norm() > kHere ? Vec2(towards.normalized()) : Vec2(std::cos(from.yaw), std::sin(from.yaw)), 1}};
}

std::vector<Gaze> gazesOfView(const QueryScene& scene, View::Kind kind, const Referents& referred,
                              const std::vector<int>& things) {
  std::vector<Gaze> gazes;
  constexpr double kApart = 0.5;  // m
  for (const Referent& r : referred) {
    const SceneThing& thing = scene.things[static_cast<std::size_t>(r.thing)];
    const Vec2 front = frontOf(scene, thing), apart = middleOf(scene, things) - thing.centre.head<2>();
    if (kind == View::Kind::kFacing) {
      gazes.push_back({-front, r.probability});
    } else if (apart.norm() < kApart) {
      gazes.push_back({front, r.probability});
    } else {
      gazes.push_back({front, kLooksAhead * r.probability});
      gazes.push_back({apart.normalized(), (1 - kLooksAhead) * r.probability});
    }
  }
  return gazes;
}

std::vector<Gaze> gazesAtFront(const QueryScene& scene, const SceneThing& thing) {
  const Vec2 front = frontOf(scene, thing);
  return {{-front, kOwnFront}, {front, 1 - kOwnFront}};
}

std::vector<Gaze> directionsOf(Relation relation, std::vector<Gaze> gazes) {
  for (Gaze& g : gazes) {
    const Vec2 gaze = g.direction;
    g.direction = relation == Relation::kLeft     ? leftOf(gaze)
                  : relation == Relation::kRight  ? Vec2(-leftOf(gaze))
                  : relation == Relation::kBehind ? gaze
                                                  : Vec2(-gaze);
  }
  return gazes;
}

Referents doorsOf(const QueryScene& scene) {
  Referents doors;
  for (std::size_t k = 0; k < scene.things.size(); ++k) {
    const auto name = scene.class_names.find(scene.things[k].label);
    if (name != scene.class_names.end() && name->second == "door") {
      doors.push_back({static_cast<int>(k), 1});
    }
  }
  for (Referent& door : doors) {
    door.probability /= static_cast<double>(doors.size());
  }
  return doors;
}

Vec2 middleOf(const QueryScene& scene, const std::vector<int>& things) {
  Vec2 middle = Vec2::Zero();
  for (const int k : things) {
    middle += scene.things[static_cast<std::size_t>(k)].centre.head<2>() / static_cast<double>(things.size());
  }
  return middle;
}

}  // namespace hgg
