#include "query/views.h"

#include <cmath>

namespace hgg {

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
  Vec2 mean = Vec2::Zero(), fronts = Vec2::Zero();
  for (const int k : things) {
    const SceneThing& thing = scene.things[static_cast<std::size_t>(k)];
    mean += thing.centre.head<2>() / static_cast<double>(things.size());
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

}  // namespace hgg
