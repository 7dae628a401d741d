#pragma once

#include <limits>
#include <vector>

#include "../map/test_map.h"
#include "traversability/planner.h"

namespace hgg {

/// A map put together from surfaces: what a robot with a sharp eye would have made of them. A leaf for every patch of
/// `leaf` (m) of a rectangle, as thick as range noise, seen from keyframes: one 0.6 m above the origin, if nothing
/// else is said.
class SurfacesWorld {
 public:
  static constexpr double kNoise = 0.01;  // m

  /// The rectangle corner + s * a + t * b, s and t from 0 to 1. `density`: points on 0.1 x 0.1 m.
  void add(const Vec3& corner, const Vec3& a, const Vec3& b, double density = 30, double leaf = 0.1,
           bool stuff = false) {
    MapNode node = nodeAt(1, Vec3::Zero());
    node.T_map_object = Pose::Identity();
    node.views = 50;
    node.stuff = stuff;
    node.anchor = 0;
    node.last_us = std::numeric_limits<Micros>::max();
    const int columns = std::max(1, static_cast<int>(std::lround(a.norm() / leaf)));
    const int rows = std::max(1, static_cast<int>(std::lround(b.norm() / leaf)));
    const Vec3 da = a / columns, db = b / rows, n = da.cross(db).normalized();
    Leaves leaves;
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < rows; ++j) {
        Belief belief;
        belief.mean = corner + (i + 0.5) * da + (j + 0.5) * db;
        belief.cov = (da * da.transpose() + db * db.transpose()) / 12 + kNoise * kNoise * n * n.transpose();
        belief.kappa = std::max(1.0, density * da.cross(db).norm() / 0.01);
        leaves.push_back(packLeaf(belief));
      }
    }
    node.geometry = shareLeaves(std::move(leaves));
    nodes_.push_back(node);
  }
  /// Level ground from (x0, y0) to (x1, y1).
  void addFloor(double x0, double y0, double x1, double y1, double z = 0, double density = 30, double leaf = 0.1) {
    add({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}, density, leaf);
  }
  /// The four sides of an upright box, without bottom and top.
  void addSides(double x0, double y0, double x1, double y1, double z0, double z1, double density = 30) {
    const Vec3 up(0, 0, z1 - z0);
    add({x0, y0, z0}, {x1 - x0, 0, 0}, up, density);
    add({x0, y1, z0}, {x1 - x0, 0, 0}, up, density);
    add({x0, y0, z0}, {0, y1 - y0, 0}, up, density);
    add({x1, y0, z0}, {0, y1 - y0, 0}, up, density);
  }

  void setEye(const Vec3& p_map) { eyes_ = {p_map}; }
  void addEye(const Vec3& p_map) { eyes_.push_back(p_map); }

  Map map() const {
    Map map;
    Micros utime_us = 0;
    for (const Vec3& p_eye : eyes_) {
      MapUpdate update;
      update.keyframe = NewKeyframe{{utime_us, Pose(Eigen::Translation3d(p_eye))}, {}};
      utime_us += kPause;
      if (&p_eye == &eyes_.front()) {
        update.created = nodes_;
      }
      map.apply(std::move(update));
    }
    return map;
  }

  CostGrid grid(const GridRegion& region = {-4, -4, 4, 4}, const TraversabilityConfig& limits = {}) const {
    return buildCostGrid(map(), *gridShape(region, limits.resolution), limits);
  }

 private:
  static constexpr Micros kPause = 60'000'000;  // us between keyframes: the robot did not walk from one to the next

  std::vector<Vec3> eyes_{{0, 0, 0.6}};
  std::vector<MapNode> nodes_;
};

/// The surface at a place nearest to height z; nullptr when the column is empty or has none within 0.3 m.
inline const Support* supportAt(const CostGrid& grid, double x, double y, double z = 0) {
  const Support* best = nullptr;
  for (const Support& s : grid.column(grid.shape.cell(grid.shape.columnOf(x), grid.shape.rowOf(y)))) {
    if (std::abs(s.height - z) < 0.3 && (best == nullptr || std::abs(s.height - z) < std::abs(best->height - z))) {
      best = &s;
    }
  }
  return best;
}

/// Cost at a place and height: unknown where there is no such surface and nothing else either, blocked where something
/// else is.
inline std::uint8_t costAt(const CostGrid& grid, double x, double y, double z = 0) {
  const Support* s = supportAt(grid, x, y, z);
  const bool is_empty = grid.column(grid.shape.cell(grid.shape.columnOf(x), grid.shape.rowOf(y))).empty();
  return s != nullptr ? s->cost : is_empty ? kCostUnknown : kCostBlocked;
}

inline bool isFree(const CostGrid& grid, double x, double y, double z = 0) { return isWalkable(costAt(grid, x, y, z)); }

}  // namespace hgg
