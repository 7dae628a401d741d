#include "query/goal.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace hgg {
namespace {

constexpr double kFarthest = 6.0;       // m from the thing: a pose farther away does not help
constexpr double kPerWorstGround = 20;  // m of way that one would take to stand on good ground instead of the worst
constexpr double kBestDistance = 0.6;   // m: near enough to reach, far enough to turn
/// Up to here the thing is within kGoalReach although the map errs about its surface. m, m of way a metre beyond it
constexpr double kSureReach = 0.8, kPerMetreUnsure = 200;
/// Beyond kGoalReach every centimetre counts more than any way. m of way, m a metre
constexpr double kTooFar = 1e4, kPerMetreTooFar = 1e3;
/// Ground is laid this far around start and thing: little at first, because laying it is what takes time. m
constexpr double kMargins[] = {3, 15, std::numeric_limits<double>::infinity()};
constexpr double kDetour = 1.5;  // times the straight way: then there may be a shorter way outside what was laid
constexpr double kEdgeInSigmas = 1.7320508;  // as query/scene.cpp

/// Where one can stand near a thing: a surface of the grid.
struct StandingPlace {
  std::uint32_t surface = 0;
  Vec3 position = Vec3::Zero();
  double distance = 0;  // m, from the thing
  double penalty = 0;   // m of way that one would take to stand elsewhere
};

/// A part of a thing seen from above: a rectangle, which leaves at an angle to the map's axes fill better than a box.
struct Footprint {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Matrix2d axes = Eigen::Matrix2d::Identity();  // unit vectors, in columns
  Eigen::Vector2d half = Eigen::Vector2d::Zero();      // half the edges along the axes, m

  double distanceTo(const Eigen::Vector2d& p) const {
    return ((axes.transpose() * (p - middle)).cwiseAbs() - half).cwiseMax(0).norm();
  }
};

/// Where a thing is: the footprints of its leaves, its own where it has none, and the box around all of it.
struct Body {
  std::vector<Footprint> parts;
  Eigen::AlignedBox3d box;

  double distanceTo(const Eigen::Vector2d& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Footprint& part : parts) {
      least = std::min(least, part.distanceTo(p));
    }
    return least;
  }
};

Body bodyOf(const MapNode& node) {
  Body body;
  const auto add = [&](const Belief& b) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(b.cov.topLeftCorner<2, 2>());
    body.parts.push_back(
        {b.mean.head<2>(), eigen.eigenvectors(), kEdgeInSigmas * eigen.eigenvalues().cwiseMax(0).cwiseSqrt()});
    const Vec3 half = kEdgeInSigmas * b.cov.diagonal().cwiseMax(0).cwiseSqrt();
    body.box.extend(b.mean - half);
    body.box.extend(b.mean + half);
  };
  for (const Leaf& leaf : leavesOf(node)) {
    add(transform(node.T_map_object, unpackLeaf(leaf)));
  }
  if (body.parts.empty()) {
    add(node.belief);
  }
  return body;
}

/// What is worse about standing on such ground, at such a distance from the thing.
double penaltyOf(const Support& ground, double distance) {
  if (distance > kGoalReach) {
    return kTooFar + kPerMetreTooFar * distance;
  }
  const double unsure = std::max(0.0, distance - kSureReach) * kPerMetreUnsure;
  return unsure +
         kPerWorstGround * (ground.cost / static_cast<double>(kCostWorst) + 0.5 * std::abs(distance - kBestDistance));
}

/// Where one can stand within kFarthest of the thing.
std::vector<StandingPlace> standings(const CostGrid& grid, const TraversabilityConfig& limits, const Body& body) {
  const GridShape& shape = grid.shape;
  const Eigen::AlignedBox3d& all = body.box;
  std::vector<StandingPlace> found;
  for (std::int32_t row = std::max(0, shape.rowOf(all.min().y() - kFarthest));
       row <= std::min(shape.height - 1, shape.rowOf(all.max().y() + kFarthest)); ++row) {
    for (std::int32_t column = std::max(0, shape.columnOf(all.min().x() - kFarthest));
         column <= std::min(shape.width - 1, shape.columnOf(all.max().x() + kFarthest)); ++column) {
      const auto cell = static_cast<std::size_t>(shape.cell(column, row));
      for (std::uint32_t k = grid.first[cell]; k < grid.first[cell + 1]; ++k) {
        const Support& s = grid.supports[k];
        // The floor that the thing is on, or one that reaches up to it.
        const double below = all.min().z() - static_cast<double>(s.height);
        if (!isWalkable(s.cost) || below <= -all.sizes().z() || below >= limits.body_height + 2.0) {
          continue;
        }
        const Vec3 p(shape.xOf(column), shape.yOf(row), static_cast<double>(s.height));
        if (const double distance = body.distanceTo(p.head<2>()); distance <= kFarthest) {
          found.push_back({k, p, distance, penaltyOf(s, distance)});
        }
      }
    }
  }
  return found;
}

PlanPoint startOn(const CostGrid& grid, const GoalStart& from) {
  PlanPoint start{from.x, from.y, from.ground_z};
  if (!start.z && from.body_z) {
    start.z = groundBelow(grid, {from.x, from.y, *from.body_z});
  }
  return start;
}

}  // namespace

Goal findGoal(const MapLeaves& map, NodeId target, const CostGrid& grid, const TraversabilityConfig& limits,
              const GoalStart& from) {
  Goal goal;
  const auto node = map.nodes.find(target);
  if (node == map.nodes.end()) {
    goal.reason = "the map has no such thing";
    return goal;
  }
  const Body body = bodyOf(node->second);
  const std::vector<StandingPlace> places = standings(grid, limits, body);
  std::vector<PlanEnd> ends;
  for (const StandingPlace& place : places) {
    ends.push_back({place.surface, place.penalty});
  }
  PlanToAny way = planToAny(grid, limits, startOn(grid, from), groundHeight(map, grid), ends);
  const bool has_near =
      std::ranges::any_of(places, [](const StandingPlace& place) { return place.distance <= kGoalReach; });
  if (way.plan.found) {
    const StandingPlace& place = places[way.end];
    const Vec3 towards = body.box.center() - place.position;
    goal = {true,
            place.position,
            std::atan2(towards.y(), towards.x()),
            place.distance,
            std::move(way.plan.path),
            way.plan.length,
            way.plan.worst_confidence,
            {}};
  }
  if (!goal.found || goal.distance > kGoalReach) {
    goal.reason =
        has_near ? fmt::format("nothing within {:.1f} m of it can be reached: {}", kGoalReach,
                               goal.found ? "obstacles, steps or unknown ground lie on every way" : way.plan.reason)
                 : fmt::format("no ground to stand on is known within {:.1f} m of it", kGoalReach);
  }
  return goal;
}

Goal findGoalInMap(const MapLeaves& map, NodeId target, const TraversabilityConfig& limits, const GoalStart& from,
                   double most_cells) {
  const auto node = map.nodes.find(target);
  const std::optional<GridRegion> whole = regionOf(map);
  Goal goal;
  if (node == map.nodes.end() || map.keyframes.empty() || !whole) {
    goal.reason = node == map.nodes.end() ? "the map has no such thing" : "the map has no ground that was walked on";
    return goal;
  }
  if (from.x < whole->x_min || from.y < whole->y_min || from.x > whole->x_max || from.y > whole->y_max) {
    goal.reason = "the start lies outside the map";
    return goal;
  }
  const Body body = bodyOf(node->second);
  const Eigen::Vector2d start(from.x, from.y);
  const Eigen::Vector2d thing =
      std::ranges::min_element(body.parts, {}, [&](const Footprint& f) { return f.distanceTo(start); })->middle;
  for (const double margin : kMargins) {
    const Eigen::Vector2d low = start.cwiseMin(thing).array() - margin, high = start.cwiseMax(thing).array() + margin;
    const GridRegion region{std::max(low.x(), whole->x_min), std::max(low.y(), whole->y_min),
                            std::min(high.x(), whole->x_max), std::min(high.y(), whole->y_max)};
    const Result<GridShape> shape = gridShape(region, limits.resolution, most_cells);
    if (!shape) {
      goal.reason = goal.reason.empty() ? "it is too far away for a way to be looked for" : goal.reason;
      return goal;
    }
    goal = findGoal(map, target, buildCostGrid(map, *shape, limits), limits, from);
    if (goal.isAtThing() && goal.path_length <= kDetour * (thing - start).norm() + margin) {
      return goal;
    }
  }
  return goal;
}

}  // namespace hgg
