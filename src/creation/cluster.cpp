#include "creation/cluster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace hgg {
namespace {

using Index = std::int32_t;

/// Clusters are found on a grid and not by radius searches in a k-d tree, as the cells do most of the work: all points
/// of a cell are in one cluster, and two cells are compared only while they are in different ones, until the first pair
/// of neighbours. No cost against nanoflann was measured.
///
/// Cells have the edge r / sqrt(3), so any two points of a cell are neighbours. The margin keeps that true after
/// rounding.
constexpr float kCellShare = 0.57735F * 0.9999F;
/// Shells of range in which r grows by at most this: then neighbours are never more than two cells apart along an axis
/// (three cells apart means a gap above 2 / sqrt(3) = 1.1547 of the shell's smallest r).
constexpr float kShellGrowth = 1.15F;
// Slack against rounding: a test on boxes or ranges may take in too much, since the test on points decides.
constexpr float kBoxSlack = 1.00001F;     // of a squared distance
constexpr float kHaloSlack = 1.001F;      // of r beyond the end of a shell
constexpr float kShellOverlap = 0.9999F;  // where the next shell begins, of the end of this one

float rangeOf(const PackedPoint& p) { return std::sqrt((p * p).sum()); }

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index root(Index i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      parent_[static_cast<std::size_t>(i)] = parent_[static_cast<std::size_t>(parent_[static_cast<std::size_t>(i)])];
      i = parent_[static_cast<std::size_t>(i)];
    }
    return i;
  }
  void unite(Index a, Index b) {
    a = root(a), b = root(b);
    if (a != b) {
      parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }

 private:
  std::vector<Index> parent_;
};

struct Cell {
  Eigen::Array3i coordinates;
  Index begin = 0, end = 0;  // into the order of the grid
  PackedPoint low, high;     // bounding box of its points
};

std::uint64_t cellKey(const Eigen::Array3i& c) {
  const auto lane = [&](int k) { return static_cast<std::uint64_t>(c[k] + (1 << 20)) & 0x1FFFFF; };
  return lane(0) << 42 | lane(1) << 21 | lane(2);
}

/// Open-addressing table from cell key to cell index, at most half full.
class CellTable {
 public:
  /// Index of the cell with this key, -1 when there is none.
  Index find(std::uint64_t key) const { return slots_[slotOf(key)].index; }

  /// The same; a new key gets `fresh`.
  Index findOrAdd(std::uint64_t key, Index fresh) {
    if (2 * (used_ + 1) > slots_.size()) {
      grow();
    }
    Slot& slot = slots_[slotOf(key)];
    if (slot.index < 0) {
      slot = {key, fresh};
      ++used_;
    }
    return slot.index;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    Index index = -1;
  };

  std::size_t slotOf(std::uint64_t key) const {
    std::size_t s = (key * 0x9E3779B97F4A7C15ULL >> 20) & (slots_.size() - 1);
    while (slots_[s].index >= 0 && slots_[s].key != key) {
      s = (s + 1) & (slots_.size() - 1);
    }
    return s;
  }

  void grow() {
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(2 * slots_.size()));
    for (const Slot& slot : old) {
      if (slot.index >= 0) {
        slots_[slotOf(slot.key)] = slot;
      }
    }
  }

  std::vector<Slot> slots_ = std::vector<Slot>(256);
  std::size_t used_ = 0;
};

/// The members of one shell, sorted by cell.
struct Grid {
  std::vector<Cell> cells;
  std::vector<Index> order;  // point indices, cell by cell
  CellTable table;
};

Grid buildGrid(std::span<const PackedPoint> points, const std::vector<Index>& members, float cell_size) {
  Grid grid;
  std::vector<Index> cell_of(members.size());
  for (std::size_t m = 0; m < members.size(); ++m) {
    const PackedPoint& p = points[static_cast<std::size_t>(members[m])];
    const Eigen::Array3i coordinates = (p.head<3>() / cell_size).floor().cast<int>();
    const Index c = grid.table.findOrAdd(cellKey(coordinates), static_cast<Index>(grid.cells.size()));
    if (c == static_cast<Index>(grid.cells.size())) {
      grid.cells.push_back({coordinates, 0, 0, p, p});
    }
    Cell& cell = grid.cells[static_cast<std::size_t>(c)];
    cell.low = cell.low.min(p), cell.high = cell.high.max(p);
    ++cell.end;  // a count until the offsets are known
    cell_of[m] = c;
  }
  Index offset = 0;
  for (Cell& cell : grid.cells) {
    cell.begin = offset;
    offset += cell.end;
    cell.end = cell.begin;
  }
  grid.order.resize(members.size());
  for (std::size_t m = 0; m < members.size(); ++m) {
    grid.order[static_cast<std::size_t>(grid.cells[static_cast<std::size_t>(cell_of[m])].end++)] = members[m];
  }
  return grid;
}

/// Squared distance of two boxes.
float boxGap(const PackedPoint& low_a, const PackedPoint& high_a, const PackedPoint& low_b, const PackedPoint& high_b) {
  const PackedPoint gap = (low_a - high_b).max(low_b - high_a).max(0.0F);
  return (gap * gap).sum();
}

bool haveNeighbours(std::span<const PackedPoint> points, const Grid& grid, const Cell& a, const Cell& b,
                    const RadiusLaw& law, float radius_max) {
  const float limit = radius_max * radius_max * kBoxSlack;
  if (boxGap(a.low, a.high, b.low, b.high) > limit) {
    return false;
  }
  for (Index i = a.begin; i < a.end; ++i) {
    const PackedPoint& p = points[static_cast<std::size_t>(grid.order[static_cast<std::size_t>(i)])];
    if (boxGap(p, p, b.low, b.high) > limit) {
      continue;
    }
    for (Index j = b.begin; j < b.end; ++j) {
      if (areNeighbours(p, points[static_cast<std::size_t>(grid.order[static_cast<std::size_t>(j)])], law)) {
        return true;
      }
    }
  }
  return false;
}

/// The half of the 5x5x5 stencil that comes after its centre (the other half is met from the other side), nearest
/// first: close cells join cheaply, and then most far ones already share a component and need no test.
std::vector<Eigen::Array3i> halfStencil() {
  std::vector<Eigen::Array3i> offsets;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) {
        if (x > 0 || (x == 0 && (y > 0 || (y == 0 && z > 0)))) {
          offsets.emplace_back(x, y, z);
        }
      }
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const auto& a, const auto& b) { return (a * a).sum() < (b * b).sum(); });
  return offsets;
}

/// Joins the neighbours among the members of one shell [r_low, r_high] and its halo.
void uniteShell(std::span<const PackedPoint> points, const std::vector<Index>& members, float r_low, float r_high,
                const RadiusLaw& law, UnionFind& components) {
  static const std::vector<Eigen::Array3i> kStencil = halfStencil();
  const Grid grid = buildGrid(points, members, r_low * kCellShare);
  for (const Cell& cell : grid.cells) {
    for (Index i = cell.begin + 1; i < cell.end; ++i) {
      components.unite(grid.order[static_cast<std::size_t>(cell.begin)], grid.order[static_cast<std::size_t>(i)]);
    }
  }
  for (const Eigen::Array3i& offset : kStencil) {
    for (const Cell& cell : grid.cells) {
      const Index c = grid.table.find(cellKey(cell.coordinates + offset));
      if (c < 0) {
        continue;
      }
      const Cell& neighbour = grid.cells[static_cast<std::size_t>(c)];
      const Index first = grid.order[static_cast<std::size_t>(cell.begin)];
      const Index second = grid.order[static_cast<std::size_t>(neighbour.begin)];
      if (components.root(first) != components.root(second) &&
          haveNeighbours(points, grid, cell, neighbour, law, r_high)) {
        components.unite(first, second);
      }
    }
  }
}

std::vector<std::int32_t> numberByFirstAppearance(UnionFind& components, std::size_t n) {
  std::vector<Index> label(n, -1), out(n);
  Index next = 0;
  for (std::size_t i = 0; i < n; ++i) {
    Index& l = label[static_cast<std::size_t>(components.root(static_cast<Index>(i)))];
    if (l < 0) {
      l = next++;
    }
    out[i] = l;
  }
  return out;
}

}  // namespace

std::vector<std::int32_t> clusterEuclidean(std::span<const PackedPoint> points, const RadiusLaw& law) {
  UnionFind components(points.size());
  std::vector<float> ranges(points.size());
  float farthest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ranges[i] = rangeOf(points[i]);
    farthest = std::max(farthest, ranges[i]);
  }
  // A pair belongs to the shell of its nearer point; the farther one is then at most r beyond the shell (its halo).
  float begin = 0, r_low = law.radius_min;
  std::vector<Index> members;
  while (begin <= farthest) {
    const float r_high = law.slope * farthest <= r_low ? r_low : r_low * kShellGrowth;
    const float end = r_high > r_low ? r_high / law.slope : std::numeric_limits<float>::infinity();
    members.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (ranges[i] >= begin && ranges[i] <= end + r_high * kHaloSlack) {
        members.push_back(static_cast<Index>(i));
      }
    }
    uniteShell(points, members, r_low, r_high, law, components);
    begin = end * kShellOverlap;
    r_low = r_high * kShellOverlap;
  }
  return numberByFirstAppearance(components, points.size());
}

}  // namespace hgg
