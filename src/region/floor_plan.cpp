#include "region/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "region/furniture.h"
#include "region/surfaces.h"
#include "traversability/cost_grid.h"

namespace hgg {
namespace {

constexpr double kResolution = 0.1;  // m: a door is ten cells wide
constexpr double kMostCells = 4e6;   // of a grid; larger maps get wider cells
constexpr double kStep = 0.5;        // m: cells beside each other that are farther apart in height are not connected
constexpr double kStorey = 1.8;      // m: what lies nearer above ground is furniture on it, no other storey
/// What stands between these heights above the ground is a wall: below are kerbs and sills, above are lintels. m
constexpr double kWallBottom = 0.3, kWallTop = 1.8;
constexpr double kOverhead = 1.8;  // m above the ground: what lies there is a roof
constexpr double kGap = 0.5;       // m: ground that was not seen between ground that was, as below furniture

constexpr std::pair<int, int> kWays[] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}};

/// A height of the ground in a cell of the grid.
struct GroundHeight {
  std::int32_t cell;
  float z;
  auto operator<=>(const GroundHeight&) const =
      default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
};

/// The grid's columns while cells are still added.
class GroundColumns {
 public:
  explicit GroundColumns(const GridShape& shape) : shape_(shape), last_(static_cast<std::size_t>(shape.cells()), -1) {}

  const GridShape& shape() const { return shape_; }
  std::vector<PlanCell>& cells() { return cells_; }
  /// The ground of a column within `reach` (m) of this height; -1: none.
  std::int32_t find(std::int32_t column, std::int32_t row, double z, double reach = kStep) const {
    if (!shape_.contains(column, row)) {
      return -1;
    }
    std::int32_t k = last_[static_cast<std::size_t>(shape_.cell(column, row))];
    while (k >= 0 && std::abs(static_cast<double>(cells_[static_cast<std::size_t>(k)].height) - z) > reach) {
      k = below_[static_cast<std::size_t>(k)];
    }
    return k;
  }
  std::int32_t add(std::int32_t column, std::int32_t row, float z) {
    std::int32_t& last = last_[static_cast<std::size_t>(shape_.cell(column, row))];
    below_.push_back(last);
    last = static_cast<std::int32_t>(cells_.size());
    cells_.push_back({.column = column, .row = row, .height = z});
    return last;
  }
  /// Calls visit(cell) for the ground of the column that p lies in.
  template <typename Visit>
  void forEachAt(const Vec3& p, Visit visit) {
    const std::int32_t column = shape_.columnOf(p.x()), row = shape_.rowOf(p.y());
    if (!shape_.contains(column, row)) {
      return;
    }
    for (std::int32_t k = last_[static_cast<std::size_t>(shape_.cell(column, row))]; k >= 0;
         k = below_[static_cast<std::size_t>(k)]) {
      visit(cells_[static_cast<std::size_t>(k)]);
    }
  }

 private:
  GridShape shape_;
  std::vector<PlanCell> cells_;
  std::vector<std::int32_t> last_, below_;  // the cells of a column are a list
};

void addSeenGround(const std::vector<LeafSheet>& ground, GroundColumns& columns) {
  const GridShape& shape = columns.shape();
  std::vector<GroundHeight> heights;
  for (const LeafSheet& sheet : ground) {
    forEachSample(sheet, shape.resolution, [&](const Vec3& p) {
      const std::int32_t column = shape.columnOf(p.x()), row = shape.rowOf(p.y());
      if (shape.contains(column, row)) {
        heights.push_back({shape.cell(column, row), static_cast<float>(p.z())});
      }
    });
  }
  std::ranges::sort(heights);
  for (std::size_t i = 0; i < heights.size();) {
    columns.add(heights[i].cell % shape.width, heights[i].cell / shape.width, heights[i].z);
    const GroundHeight lowest = heights[i];
    while (i < heights.size() && heights[i].cell == lowest.cell &&
           heights[i].z < lowest.z + static_cast<float>(kStorey)) {
      ++i;
    }
  }
}

/// Ground beside ground that was seen, as far as kGap.
void widen(GroundColumns& columns) {
  const int rounds = static_cast<int>(std::lround(kGap / columns.shape().resolution));
  std::size_t begin = 0;
  for (int round = 0; round < rounds; ++round) {
    const std::size_t end = columns.cells().size();
    for (std::size_t k = begin; k < end; ++k) {
      const PlanCell from = columns.cells()[k];
      for (const auto& [x, y] : kWays) {
        const std::int32_t column = from.column + x, row = from.row + y;
        if (columns.shape().contains(column, row) &&
            columns.find(column, row, static_cast<double>(from.height), kStorey) < 0) {
          columns.add(column, row, from.height);
        }
      }
    }
    begin = end;
  }
}

void addWalls(const StuffSurfaces& surfaces, GroundColumns& columns) {
  for (const LeafSheet& sheet : surfaces.standing) {
    forEachSample(sheet, columns.shape().resolution / 2, [&](const Vec3& p) {
      columns.forEachAt(p, [&](PlanCell& cell) {
        const double above = p.z() - static_cast<double>(cell.height);
        cell.is_wall = cell.is_wall || (above > kWallBottom && above < kWallTop);
      });
    });
  }
  for (const LeafSheet& sheet : surfaces.overhead) {
    forEachSample(sheet, columns.shape().resolution, [&](const Vec3& p) {
      columns.forEachAt(p, [&](PlanCell& cell) {
        cell.has_roof = cell.has_roof || p.z() - static_cast<double>(cell.height) > kOverhead;
      });
    });
  }
}

/// Takes the widening back where it closed no gap: what is no farther than kGap from where no ground is.
std::vector<bool> isFringe(const GroundColumns& columns, const std::vector<PlanCell>& cells, std::size_t seen) {
  std::vector<int> depth(cells.size(), -1);
  std::vector<std::size_t> front;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    for (const auto& [x, y] : kWays) {
      if (depth[k] < 0 &&
          columns.find(cells[k].column + x, cells[k].row + y, static_cast<double>(cells[k].height)) < 0) {
        depth[k] = 1;
        front.push_back(k);
      }
    }
  }
  const int rounds = static_cast<int>(std::lround(kGap / columns.shape().resolution));
  for (std::size_t i = 0; i < front.size(); ++i) {
    const PlanCell& from = cells[front[i]];
    for (const auto& [x, y] : kWays) {
      const std::int32_t next = columns.find(from.column + x, from.row + y, static_cast<double>(from.height));
      if (next >= 0 && depth[static_cast<std::size_t>(next)] < 0 && depth[front[i]] < rounds) {
        depth[static_cast<std::size_t>(next)] = depth[front[i]] + 1;
        front.push_back(static_cast<std::size_t>(next));
      }
    }
  }
  std::vector<bool> fringe(cells.size(), false);
  for (std::size_t k = seen; k < cells.size(); ++k) {
    fringe[k] = depth[k] >= 0 && !cells[k].is_wall;
  }
  return fringe;
}

void findNeighbors(FloorPlan& plan) {
  plan.neighbors.assign(plan.cells.size(), {});
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    const PlanCell& cell = plan.cells[k];
    for (std::size_t w = 0; w < 8; ++w) {
      std::int32_t& neighbor = plan.neighbors[k][w] = -1;
      for (const PlanCell& other : plan.at(cell.column + kWays[w].first, cell.row + kWays[w].second)) {
        if (std::abs(other.height - cell.height) <= static_cast<float>(kStep)) {
          neighbor = static_cast<std::int32_t>(&other - plan.cells.data());
        }
      }
    }
  }
}

/// The distance of each cell to the nearest wall, which neighbours hand on to each other.
void measureRoom(FloorPlan& plan) {
  constexpr float kNoWall = 1e3F;  // m
  std::vector<std::int32_t> wall(plan.cells.size(), -1);
  std::vector<std::int32_t> front;
  for (std::size_t k = 0; k < plan.cells.size(); ++k) {
    plan.cells[k].room = plan.cells[k].is_wall ? 0 : kNoWall;
    if (plan.cells[k].is_wall) {
      wall[k] = static_cast<std::int32_t>(k);
      front.push_back(wall[k]);
    }
  }
  for (std::size_t i = 0; i < front.size(); ++i) {
    const auto k = static_cast<std::size_t>(front[i]);
    const PlanCell& source = plan.cells[static_cast<std::size_t>(wall[k])];
    for (const std::int32_t next : plan.neighbors[k]) {
      if (next < 0) {
        continue;
      }
      PlanCell& cell = plan.cells[static_cast<std::size_t>(next)];
      const double distance = plan.shape.resolution * std::hypot(cell.column - source.column, cell.row - source.row);
      if (static_cast<float>(distance) < cell.room) {
        cell.room = static_cast<float>(distance);
        wall[static_cast<std::size_t>(next)] = wall[k];
        front.push_back(next);
      }
    }
  }
}

}  // namespace

FloorPlan buildFloorPlan(const MapLeaves& map) {
  FloorPlan plan;
  const auto region = regionOf(map);
  if (!region) {
    return plan;
  }
  const double area = (region->x_max - region->x_min) * (region->y_max - region->y_min);
  const auto shape = gridShape(*region, std::max(kResolution, std::sqrt(area / kMostCells)));
  if (!shape) {
    return plan;
  }
  plan.shape = *shape;
  StuffSurfaces surfaces = surfacesOf(map);
  keepUnderRoofs(surfaces);
  GroundColumns columns(plan.shape);
  addSeenGround(surfaces.ground, columns);
  const std::size_t seen = columns.cells().size();
  widen(columns);
  addWalls(surfaces, columns);
  const std::vector<bool> fringe = isFringe(columns, columns.cells(), seen);
  for (std::size_t k = 0; k < fringe.size(); ++k) {
    if (!fringe[k]) {
      plan.cells.push_back(columns.cells()[k]);
      plan.cells.back().was_seen = k < seen;
    }
  }
  std::ranges::sort(plan.cells, {},
                    [&](const PlanCell& c) { return std::pair(plan.shape.cell(c.column, c.row), c.height); });
  plan.first.assign(static_cast<std::size_t>(plan.shape.cells()) + 1, 0);
  for (const PlanCell& c : plan.cells) {
    ++plan.first[static_cast<std::size_t>(plan.shape.cell(c.column, c.row)) + 1];
  }
  for (std::size_t k = 1; k < plan.first.size(); ++k) {
    plan.first[k] += plan.first[k - 1];
  }
  findNeighbors(plan);
  removeFurniture(plan);
  measureRoom(plan);
  return plan;
}

}  // namespace hgg
