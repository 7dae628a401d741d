#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/relative_neighbors.h"
#include "core/types.h"

namespace hgg {

/// An index over points that come, go and move, each under an id of its caller's: an octree whose root grows with what
/// it holds and whose leaves split and join with what is in them. A change costs the depth of the tree (about the
/// logarithm of the map's size over a leaf's), never a rebuild; a query costs what it finds. The answers depend on the
/// points only and not on the order in which they came.
///
/// Every cell knows a box around its points. Boxes only grow until their cell splits, joins or empties, so that they
/// may be wider than the points, but never wider than the cell.
///
/// Why not a k-d tree: most nodes around the robot move in every frame. One that is built anew costs what the map
/// costs, and nanoflann's dynamic one takes a move as a removal, which only marks the point, and an insertion, which
/// builds trees of twice the size again and again; nor does it let the caller say what to skip, which the neighbourhood
/// graph lives on.
///
/// A point may have a reach: the index then finds the points that a place is within the reach of.
class PointIndex {
 public:
  using Id = std::int64_t;

  std::size_t size() const { return handles_.size(); }
  /// Of a point that is there; stays the same until it is removed. -1 when there is none.
  int find(Id id) const;
  /// Handles are below this, and given again when they are free.
  std::size_t handleLimit() const { return points_.size(); }

  /// A new id; returns its handle. Any coordinates are taken: those beyond 1e9 m, or not finite, only cost time.
  int insert(Id id, const Vec3& p);
  void remove(int handle);
  void move(int handle, const Vec3& p);
  /// m; 0 at first.
  void setReach(int handle, double reach);

  bool isUsed(int handle) const { return points_[static_cast<std::size_t>(handle)].leaf >= 0; }
  double reachOf(int handle) const { return points_[static_cast<std::size_t>(handle)].reach; }
  Id idOf(int handle) const { return points_[static_cast<std::size_t>(handle)].id; }
  const Vec3& position(int handle) const { return points_[static_cast<std::size_t>(handle)].p; }

  /// Ids of the points within `radius` of `centre`, ascending.
  std::vector<Id> near(const Vec3& centre, double radius) const;

  /// Visits the handles of every box for which `skip(box, square distance from `towards` to the box)` is false, nearer
  /// boxes first; ends when `visit(handle)` returns true and then returns true.
  template <typename Skip, typename Visit>
  bool search(const Vec3& towards, Skip skip, Visit visit) const {
    return root_ >= 0 && search(root_, squareGap(cell(root_), towards), towards, skip, visit);
  }

  /// Visits the handles of the points that lie no farther from p than their reach and `slack` more (m).
  template <typename Visit>
  void reaching(const Vec3& p, double slack, Visit visit) const {
    const auto square = [&](double reach) { return (reach + slack) * (reach + slack); };
    search(
        p, [&](const Cell& box, double gap) { return gap > square(box.reach); },
        [&](int k) {
          if ((position(k) - p).squaredNorm() <= square(points_[static_cast<std::size_t>(k)].reach)) {
            visit(k);
          }
          return false;
        });
  }

 private:
  struct Point {
    Vec3 p;
    double reach = 0;
    Id id = 0;
    int leaf = -1;
  };
  /// A cube. Its points are in its eight children, or with it when it has none.
  struct Cell : CellBounds {
    double reach = 0;            // the largest of its points
    Vec3 corner = Vec3::Zero();  // lowest
    double edge = 0;             // m
    int parent = -1, count = 0;
    bool is_leaf = true;
    std::array<int, 8> children{-1, -1, -1, -1, -1, -1, -1, -1};
    std::vector<int> points;  // of a leaf
  };

  const Cell& cell(int c) const { return cells_[static_cast<std::size_t>(c)]; }
  Cell& cell(int c) { return cells_[static_cast<std::size_t>(c)]; }
  int newCell(int parent, const Vec3& corner, double edge, const Vec3& p);
  void freeCell(int c);
  int childFor(int c, const Vec3& p);
  void attach(int handle);
  void detach(int handle);
  void growTo(const Vec3& p);
  void split(int leaf);
  void join(int c);
  void fitLeaf(int leaf);
  void lowerReach(int c);

  template <typename Skip, typename Visit>
  bool search(int c, double gap, const Vec3& towards, Skip& skip, Visit& visit) const {
    const Cell& self = cell(c);
    if (skip(self, gap)) {
      return false;
    }
    if (self.is_leaf) {
      return std::any_of(self.points.begin(), self.points.end(), visit);
    }
    std::array<std::pair<double, int>, 8> nearer;
    std::size_t count = 0;
    for (const int child : self.children) {
      if (child >= 0) {
        const double child_gap = squareGap(cell(child), towards);
        std::size_t slot = count++;
        for (; slot > 0 && nearer[slot - 1].first > child_gap; --slot) {
          nearer[slot] = nearer[slot - 1];
        }
        nearer[slot] = {child_gap, child};
      }
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (search(nearer[k].second, nearer[k].first, towards, skip, visit)) {
        return true;
      }
    }
    return false;
  }

  std::unordered_map<Id, int> handles_;
  std::vector<Point> points_;
  std::vector<Cell> cells_;
  std::vector<int> free_points_, free_cells_;
  int root_ = -1;
};

}  // namespace hgg
