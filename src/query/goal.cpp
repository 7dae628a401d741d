#include "query/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace hgg {
namespace {

constexpr double kFarthest = 6.0;  // m from the thing: a pose farther away does not help
constexpr double kApart = 0.5;     // m between poses that are tried: next to one that fails the next fails, too
constexpr int kTries = 24, kFarTries = 40;  // paths that are looked for
constexpr double kPerMetre = 0.05;     // of a pose's score: a metre of way counts as much as 5 % of the worst ground
constexpr double kBestDistance = 0.6;  // m: near enough to reach, far enough to turn
constexpr double kEdgeInSigmas = 1.7320508;  // as query/scene.cpp

struct StandingPlace {
  Vec3 position = Vec3::Zero();
  double distance = 0, score = 0;
};

/// The boxes of a node's leaves; of the node where it has none.
std::vector<Eigen::AlignedBox3d> surfacesOf(const MapNode& node) {
  std::vector<Eigen::AlignedBox3d> boxes;
  const auto add = [&](const Belief& b) {
    const Vec3 half = kEdgeInSigmas * b.cov.diagonal().cwiseMax(0).cwiseSqrt();
    boxes.emplace_back(b.mean - half, b.mean + half);
  };
  for (const Leaf& leaf : leavesOf(node)) {
    add(transform(node.T_map_object, unpackLeaf(leaf)));
  }
  if (boxes.empty()) {
    add(node.belief);
  }
  return boxes;
}

double groundDistance(const std::vector<Eigen::AlignedBox3d>& boxes, double x, double y) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::AlignedBox3d& b : boxes) {
    const double dx = std::max({b.min().x() - x, x - b.max().x(), 0.0});
    const double dy = std::max({b.min().y() - y, y - b.max().y(), 0.0});
    least = std::min(least, std::hypot(dx, dy));
  }
  return least;
}

/// Where one can stand within `reach` of the thing and no nearer than `least`, the best first.
std::vector<StandingPlace> standings(const CostGrid& grid, const TraversabilityConfig& limits, const MapNode& node,
                                     const PlanPoint& from, double least, double reach) {
  const std::vector<Eigen::AlignedBox3d> boxes = surfacesOf(node);
  Eigen::AlignedBox3d all;
  for (const Eigen::AlignedBox3d& b : boxes) {
    all.extend(b);
  }
  const GridShape& shape = grid.shape;
  std::vector<StandingPlace> found;
  const double step = std::max(shape.resolution, limits.footprint_radius / 2);  // m
  const auto stride = static_cast<std::int32_t>(std::max(1.0, std::round(step / shape.resolution)));
  for (std::int32_t row = std::max(0, shape.rowOf(all.min().y() - reach));
       row <= std::min(shape.height - 1, shape.rowOf(all.max().y() + reach)); row += stride) {
    for (std::int32_t column = std::max(0, shape.columnOf(all.min().x() - reach));
         column <= std::min(shape.width - 1, shape.columnOf(all.max().x() + reach)); column += stride) {
      const double x = shape.xOf(column), y = shape.yOf(row);
      const double distance = groundDistance(boxes, x, y);
      if (distance > reach || distance < least) {
        continue;
      }
      for (const Support& s : grid.column(shape.cell(column, row))) {
        // The floor that the thing is on, or one that reaches up to it.
        const double below = all.min().z() - static_cast<double>(s.height);
        if (isWalkable(s.cost) && below > -all.sizes().z() && below < limits.body_height + 2.0) {
          const double way = std::hypot(x - from.x, y - from.y);
          const double score = s.cost / static_cast<double>(kCostWorst) + kPerMetre * way +
                               (reach > kGoalReach ? distance : 0.5 * std::abs(distance - kBestDistance));
          found.push_back({Vec3(x, y, static_cast<double>(s.height)), distance, score});
        }
      }
    }
  }
  std::ranges::stable_sort(found, {}, &StandingPlace::score);
  return found;
}

/// The first of the standings that a path leads to; `why` is what stopped the first of those that failed.
std::optional<Goal> firstReachable(const std::vector<StandingPlace>& options, const MapNode& node, const CostGrid& grid,
                                   const TraversabilityConfig& limits, const PlanPoint& from, double ground_z,
                                   int tries, std::string& why) {
  Eigen::AlignedBox3d all;
  for (const Eigen::AlignedBox3d& b : surfacesOf(node)) {
    all.extend(b);
  }
  const Vec3 middle = all.center();
  std::vector<Vec3> tried;
  for (const StandingPlace& s : options) {
    if (std::ranges::any_of(tried, [&](const Vec3& t) { return (t - s.position).norm() < kApart; })) {
      continue;
    }
    if (static_cast<int>(tried.size()) == tries) {
      break;
    }
    tried.push_back(s.position);
    Plan plan = planPath(grid, limits, {from, {s.position.x(), s.position.y(), s.position.z()}, ground_z, false});
    if (plan.found) {
      const Vec3 towards = middle - s.position;
      return Goal{true, s.position, std::atan2(towards.y(), towards.x()), s.distance, std::move(plan.path), {}};
    }
    why = why.empty() ? plan.reason : why;
  }
  return std::nullopt;
}

}  // namespace

Goal findGoal(const Map& map, NodeId target, const CostGrid& grid, const TraversabilityConfig& limits,
              const PlanPoint& from, double ground_z) {
  Goal none;
  const MapNode* node = map.find(target);
  if (node == nullptr) {
    none.reason = "the map has no such thing";
    return none;
  }
  std::string why;
  const std::vector<StandingPlace> near = standings(grid, limits, *node, from, 0, kGoalReach);
  if (std::optional<Goal> goal = firstReachable(near, *node, grid, limits, from, ground_z, kTries, why)) {
    return *goal;
  }
  why = near.empty() ? fmt::format("no ground to stand on is known within {:.1f} m of it", kGoalReach)
                     : fmt::format("nothing within {:.1f} m of it can be reached ({})", kGoalReach, why);
  std::string far_why;
  const std::vector<StandingPlace> far = standings(grid, limits, *node, from, kGoalReach, kFarthest);
  if (std::optional<Goal> goal = firstReachable(far, *node, grid, limits, from, ground_z, kFarTries, far_why)) {
    goal->reason = why;
    return *goal;
  }
  none.reason = why;
  return none;
}

}  // namespace hgg
