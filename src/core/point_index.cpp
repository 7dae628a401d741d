#include "core/point_index.h"

#include <cmath>
#include <cstdlib>

namespace hgg {
namespace {

constexpr std::size_t kSplit = 24;        // a leaf with more points splits
constexpr int kJoin = 12;                 // children with no more points join; fewer, so that it does not go to and fro
constexpr double kFirstEdge = 64.0;       // m, of the first root
constexpr double kSmallestEdge = 0.25;    // m; a leaf of this size keeps all of its points
constexpr double kFarthest = 1073741824;  // m, 2^30: what lies farther is filed as if it lay there

/// Where p is filed: a coordinate that is no number, as if it were 0.
Vec3 placeOf(const Vec3& p) {
  const auto filed = [](double x) { return std::isnan(x) ? 0.0 : std::clamp(x, -kFarthest, kFarthest); };
  return {filed(p.x()), filed(p.y()), filed(p.z())};
}

bool isWithin(const Vec3& corner, double edge, const Vec3& place) {
  return ((place - corner).array() >= 0).all() && ((place - corner).array() < edge).all();
}

int octantOf(const Vec3& corner, double edge, const Vec3& place) {
  const Vec3 centre = corner + Vec3::Constant(0.5 * edge);
  return (place.x() >= centre.x() ? 1 : 0) + (place.y() >= centre.y() ? 2 : 0) + (place.z() >= centre.z() ? 4 : 0);
}

Vec3 cornerOf(int octant, const Vec3& corner, double edge) {
  return corner + 0.5 * edge * Vec3(octant & 1, (octant >> 1) & 1, (octant >> 2) & 1);
}

}  // namespace

int PointIndex::find(Id id) const {
  const auto it = handles_.find(id);
  return it == handles_.end() ? -1 : it->second;
}

int PointIndex::insert(Id id, const Vec3& p) {
  int handle = static_cast<int>(points_.size());
  if (free_points_.empty()) {
    points_.emplace_back();
  } else {
    handle = free_points_.back();
    free_points_.pop_back();
  }
  if (!handles_.emplace(id, handle).second) {
    std::abort();  // a caller inserted an id twice
  }
  points_[static_cast<std::size_t>(handle)] = {p, 0, id, -1};
  attach(handle);
  return handle;
}

void PointIndex::remove(int handle) {
  detach(handle);
  handles_.erase(idOf(handle));
  points_[static_cast<std::size_t>(handle)].leaf = -1;
  free_points_.push_back(handle);
}

void PointIndex::move(int handle, const Vec3& p) {
  Point& point = points_[static_cast<std::size_t>(handle)];
  const Cell& leaf = cell(point.leaf);
  if (!isWithin(leaf.corner, leaf.edge, placeOf(p))) {
    detach(handle);
    point.p = p;
    attach(handle);
    return;
  }
  point.p = p;
  for (int c = point.leaf; c >= 0 && !cell(c).holds(p); c = cell(c).parent) {
    cell(c).extend(p);
  }
}

void PointIndex::setReach(int handle, double reach) {
  Point& point = points_[static_cast<std::size_t>(handle)];
  const bool falls = reach < point.reach;
  point.reach = reach;
  for (int c = point.leaf; !falls && c >= 0 && cell(c).reach < reach; c = cell(c).parent) {
    cell(c).reach = reach;
  }
  if (falls) {
    lowerReach(point.leaf);
  }
}

std::vector<PointIndex::Id> PointIndex::near(const Vec3& centre, double radius) const {
  std::vector<Id> ids;
  const double square = radius * radius;
  search(
      centre, [&](const CellBounds&, double gap) { return gap > square; },
      [&](int k) {
        if ((position(k) - centre).squaredNorm() <= square) {
          ids.push_back(idOf(k));
        }
        return false;
      });
  std::sort(ids.begin(), ids.end());
  return ids;
}

int PointIndex::newCell(int parent, const Vec3& corner, double edge, const Vec3& p) {
  int c = static_cast<int>(cells_.size());
  if (free_cells_.empty()) {
    cells_.emplace_back();
  } else {
    c = free_cells_.back();
    free_cells_.pop_back();
  }
  Cell& made = cell(c);
  std::vector<int> points = std::move(made.points);  // empty, for its memory
  made = {};
  made.points = std::move(points);
  made.low = made.high = p;
  made.corner = corner, made.edge = edge, made.parent = parent;
  return c;
}

void PointIndex::freeCell(int c) {
  cell(c).points.clear();
  free_cells_.push_back(c);
}

/// The child of a cell that p belongs to, made where it is missing.
int PointIndex::childFor(int c, const Vec3& p) {
  const int octant = octantOf(cell(c).corner, cell(c).edge, placeOf(p));
  const auto o = static_cast<std::size_t>(octant);
  if (cell(c).children[o] < 0) {
    const int child = newCell(c, cornerOf(octant, cell(c).corner, cell(c).edge), 0.5 * cell(c).edge, p);
    cell(c).children[o] = child;  // newCell() may have moved the cells
  }
  return cell(c).children[o];
}

/// Makes the root hold p.
void PointIndex::growTo(const Vec3& p) {
  const Vec3 place = placeOf(p);
  if (root_ < 0) {
    root_ = newCell(-1, kFirstEdge * (place / kFirstEdge).array().floor().matrix(), kFirstEdge, p);
  }
  while (!isWithin(cell(root_).corner, cell(root_).edge, place)) {
    const double edge = cell(root_).edge;
    Vec3 corner = cell(root_).corner;
    int octant = 0;  // of the old root in the new
    for (int axis = 0; axis < 3; ++axis) {
      if (place[axis] < corner[axis]) {
        corner[axis] -= edge;
        octant |= 1 << axis;
      }
    }
    if (cell(root_).is_leaf) {
      cell(root_).corner = corner, cell(root_).edge = 2 * edge;
      continue;
    }
    const int grown = newCell(-1, corner, 2 * edge, cell(root_).low);
    const Cell& old = cell(root_);
    cell(grown).high = old.high;
    cell(grown).reach = old.reach, cell(grown).count = old.count;
    cell(grown).is_leaf = false;
    cell(grown).children[static_cast<std::size_t>(octant)] = root_;
    cell(root_).parent = grown;
    root_ = grown;
  }
}

void PointIndex::attach(int handle) {
  Point& point = points_[static_cast<std::size_t>(handle)];
  growTo(point.p);
  for (int c = root_;; c = childFor(c, point.p)) {
    Cell& self = cell(c);
    self.extend(point.p);
    self.reach = std::max(self.reach, point.reach);
    ++self.count;
    if (self.is_leaf) {
      self.points.push_back(handle);
      point.leaf = c;
      if (self.points.size() > kSplit && self.edge > kSmallestEdge) {
        split(c);
      }
      return;
    }
  }
}

void PointIndex::detach(int handle) {
  const int leaf = points_[static_cast<std::size_t>(handle)].leaf;
  std::erase(cell(leaf).points, handle);
  int small = -1;  // the largest cell around that need not be split any more
  for (int c = leaf; c >= 0; c = cell(c).parent) {
    --cell(c).count;
    small = cell(c).count <= kJoin && !cell(c).is_leaf ? c : small;
  }
  if (small >= 0) {
    join(small);
    lowerReach(small);
  } else {
    fitLeaf(leaf);
    lowerReach(leaf);
  }
  for (int c = small >= 0 ? small : leaf; c >= 0 && cell(c).count == 0;) {
    const int parent = cell(c).parent;
    if (parent >= 0) {
      std::ranges::replace(cell(parent).children, c, -1);
    } else {
      root_ = -1;
    }
    freeCell(c);
    c = parent;
  }
}

/// Hands the points of a leaf down to children.
void PointIndex::split(int leaf) {
  const std::vector<int> points = std::exchange(cell(leaf).points, {});
  cell(leaf).is_leaf = false;
  for (const int handle : points) {
    const Point& point = points_[static_cast<std::size_t>(handle)];
    const int child = childFor(leaf, point.p);
    Cell& self = cell(child);
    self.extend(point.p);
    self.reach = std::max(self.reach, point.reach);
    ++self.count;
    self.points.push_back(handle);
    points_[static_cast<std::size_t>(handle)].leaf = child;
  }
  for (std::size_t o = 0; o < 8; ++o) {
    const int child = cell(leaf).children[o];
    if (child >= 0 && cell(child).points.size() > kSplit && cell(child).edge > kSmallestEdge) {
      split(child);
    }
  }
}

/// Makes a cell the leaf of all that is below it.
void PointIndex::join(int c) {
  std::vector<int> open, points;
  std::ranges::copy_if(cell(c).children, std::back_inserter(open), [](int child) { return child >= 0; });
  while (!open.empty()) {
    const int below = open.back();
    open.pop_back();
    const Cell& self = cell(below);
    points.insert(points.end(), self.points.begin(), self.points.end());
    if (!self.is_leaf) {
      std::ranges::copy_if(self.children, std::back_inserter(open), [](int child) { return child >= 0; });
    }
    freeCell(below);
  }
  cell(c).is_leaf = true;
  cell(c).children.fill(-1);
  for (const int handle : points) {
    points_[static_cast<std::size_t>(handle)].leaf = c;
  }
  cell(c).points = std::move(points);
  fitLeaf(c);
}

/// The box of a leaf as small as its points allow.
void PointIndex::fitLeaf(int leaf) {
  Cell& self = cell(leaf);
  if (self.points.empty()) {
    return;
  }
  self.low = self.high = position(self.points[0]);
  for (const int handle : self.points) {
    self.extend(position(handle));
  }
}

/// The reach of a leaf and of what holds it, after one of its points has less of it or is gone.
void PointIndex::lowerReach(int c) {
  for (; c >= 0; c = cell(c).parent) {
    double reach = 0;
    for (const int handle : cell(c).points) {
      reach = std::max(reach, points_[static_cast<std::size_t>(handle)].reach);
    }
    for (const int child : cell(c).children) {
      reach = child >= 0 ? std::max(reach, cell(child).reach) : reach;
    }
    if (reach == cell(c).reach) {
      return;
    }
    cell(c).reach = reach;
  }
}

}  // namespace hgg
