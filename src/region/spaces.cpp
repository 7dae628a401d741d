#include <algorithm>
#include <numeric>

#include "core/units.h"
#include "region/floor_plan.h"

namespace hgg {
namespace {

/// Two rooms are one where the way between them is wider than this share of the narrower one. A door of 0.9 m in a
/// corridor of 1.5 m has 0.6; the ends of an L-shaped corridor have 0.85 between them, and so have noisy walls.
constexpr double kDoor = 0.72;
/// Half of the width that a person needs, m: what is narrower is a part of what is beside it.
constexpr double kPerson = 0.35;
constexpr double kRoofed = 0.03;  // share of a space under a roof that was seen: a LiDAR sees a part of it only

/// Sets of cells that grow together.
class Basins {
 public:
  explicit Basins(const std::vector<PlanCell>& cells) : parent_(cells.size(), -1), peak_(cells.size(), 0) {}

  void begin(std::int32_t cell, double room) {
    parent_[static_cast<std::size_t>(cell)] = cell;
    peak_[static_cast<std::size_t>(cell)] = room;
  }
  void join(std::int32_t cell, std::int32_t basin) { parent_[static_cast<std::size_t>(cell)] = basin; }
  bool has(std::int32_t cell) const { return parent_[static_cast<std::size_t>(cell)] >= 0; }
  double peakOf(std::int32_t basin) const { return peak_[static_cast<std::size_t>(basin)]; }
  std::int32_t find(std::int32_t cell) {
    std::int32_t root = cell;
    while (parent_[static_cast<std::size_t>(root)] != root) {
      root = parent_[static_cast<std::size_t>(root)];
    }
    while (parent_[static_cast<std::size_t>(cell)] != root) {
      cell = std::exchange(parent_[static_cast<std::size_t>(cell)], root);
    }
    return root;
  }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<double> peak_;  // m, of the basin that begins in a cell
};

bool isOne(double way, double narrower) { return way >= kDoor * narrower || narrower < kPerson; }

/// Gives the cell to the widest basin around it, and joins basins that it connects well.
void flood(const FloorPlan& plan, std::int32_t k, Basins& basins) {
  const double room = static_cast<double>(plan.cells[static_cast<std::size_t>(k)].room);
  std::int32_t widest = -1;
  for (const std::int32_t next : plan.neighbors[static_cast<std::size_t>(k)]) {
    if (next < 0 || !basins.has(next)) {
      continue;
    }
    const std::int32_t other = basins.find(next);
    if (widest < 0 || other == widest) {
      widest = other;
      continue;
    }
    const bool other_is_wider = basins.peakOf(other) > basins.peakOf(widest);
    const auto [wide, narrow] = other_is_wider ? std::pair(other, widest) : std::pair(widest, other);
    if (isOne(room, basins.peakOf(narrow))) {
      basins.join(narrow, wide);
    }
    widest = wide;
  }
  if (widest < 0) {
    basins.begin(k, room);
  } else {
    basins.join(k, widest);
  }
}

}  // namespace

void cutIntoSpaces(FloorPlan& plan) {
  std::vector<std::int32_t> order;
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    if (!plan.cells[k].is_wall) {
      order.push_back(static_cast<std::int32_t>(k));
    }
  }
  std::ranges::stable_sort(order, [&](std::int32_t a, std::int32_t b) {
    return plan.cells[static_cast<std::size_t>(a)].room > plan.cells[static_cast<std::size_t>(b)].room;
  });
  Basins basins(plan.cells);
  for (const std::int32_t k : order) {
    flood(plan, k, basins);
  }
  std::vector<std::int32_t> space_of(plan.cells.size(), -1);
  std::vector<std::int32_t> roofed;
  plan.spaces.clear();
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    PlanCell& cell = plan.cells[k];
    cell.space = -1;
    if (cell.is_wall) {
      continue;
    }
    const std::int32_t basin = basins.find(static_cast<std::int32_t>(k));
    std::int32_t& space = space_of[static_cast<std::size_t>(basin)];
    if (space < 0) {
      space = static_cast<std::int32_t>(plan.spaces.size());
      plan.spaces.push_back({.room = basins.peakOf(basin)});
      roofed.push_back(0);
    }
    cell.space = space;
    ++plan.spaces[static_cast<std::size_t>(space)].cells;
    roofed[static_cast<std::size_t>(space)] += cell.has_roof ? 1 : 0;
  }
  for (std::size_t s = 0; s < plan.spaces.size(); ++s) {
    plan.spaces[s].roofed = static_cast<double>(roofed[s]) / plan.spaces[s].cells;
  }
}

bool isPlace(const FloorPlan& plan, std::int32_t space) {
  constexpr double kLeastArea = 1;  // m^2
  const Space& s = plan.spaces[static_cast<std::size_t>(space)];
  return s.room >= kPerson && s.cells * square(plan.shape.resolution) >= kLeastArea;
}

bool isRoom(const FloorPlan& plan, std::int32_t space) {
  return isPlace(plan, space) && plan.spaces[static_cast<std::size_t>(space)].roofed >= kRoofed;
}

bool isWallBetween(const FloorPlan& plan, const Vec3& a, const Vec3& b) {
  constexpr double kStorey = 3;  // m: walls of other storeys are not between
  const int steps = static_cast<int>(2 * (b - a).head<2>().norm() / plan.shape.resolution) + 1;
  for (int k = 0; k <= steps; ++k) {
    const Vec3 p = a + (b - a) * k / steps;
    for (const PlanCell& cell : plan.at(plan.shape.columnOf(p.x()), plan.shape.rowOf(p.y()))) {
      if (cell.is_wall && std::abs(p.z() - static_cast<double>(cell.height)) < kStorey) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace hgg
