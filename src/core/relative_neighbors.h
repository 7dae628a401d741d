#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/types.h"

namespace hgg {

/// An axis-aligned box that holds points.
struct CellBounds {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  bool holds(const Vec3& p) const { return (p.array() >= low.array()).all() && (p.array() <= high.array()).all(); }
  void extend(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
};

/// Squared distance from p to a box, m^2; 0 inside of it. Never more than that to a point of the box, rounding
/// included.
inline double squareGap(const CellBounds& box, const Vec3& p) {
  return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).squaredNorm();
}

/// Points that come between a position p_i and what lies behind them: k blocks j when max(d(i,k), d(j,k)) < d(i,j). Any
/// points will do; the nearest of those that none of the others blocks hide nearly everything there is.
class Blockers {
 public:
  static constexpr std::size_t kMost = 16;

  explicit Blockers(const Vec3& p_i) : p_i_(p_i) {}

  /// Keeps the kMost nearest of what is added, nearest first.
  void add(const Vec3& p) {
    const Vec3 offset = p - p_i_;
    const double square = offset.squaredNorm();
    if (count_ == kMost && square >= square_[kMost - 1]) {
      return;
    }
    std::size_t slot = count_ < kMost ? count_++ : kMost - 1;
    for (; slot > 0 && square_[slot - 1] > square; --slot) {
      square_[slot] = square_[slot - 1], offset_[slot] = offset_[slot - 1], point_[slot] = point_[slot - 1];
    }
    square_[slot] = square, offset_[slot] = offset, point_[slot] = p;
  }

  /// True when a blocker comes between p_i and every point of the box: all of the box is nearer to the blocker than to
  /// p_i, and farther from p_i than the blocker is. The margins keep points that tie in exact arithmetic.
  bool hideBox(const CellBounds& box, double gap) {
    const Vec3 low = box.low - p_i_, high = box.high - p_i_;
    const double margin = 1e-12 * (low.squaredNorm() + high.squaredNorm());
    for (std::size_t k = 0; k < count_ && square_[k] < gap * (1 - 1e-12); ++k) {
      const Vec3& n = offset_[k];
      const double nearest =
          n.cwiseProduct(low).cwiseMin(n.cwiseProduct(high)).sum();  // least (q - p_i) . n in the box
      if (2 * nearest > square_[k] + margin) {
        square_reach_ = std::max(square_reach_, square_[k]);
        return true;
      }
    }
    return false;
  }

  /// True when one of them blocks a point at this squared distance from p_i. Exact.
  bool hidePoint(const Vec3& p, double square_ij) {
    for (std::size_t k = 0; k < count_ && square_[k] < square_ij; ++k) {
      if ((point_[k] - p).squaredNorm() < square_ij) {
        square_reach_ = std::max(square_reach_, square_[k]);
        return true;
      }
    }
    return false;
  }

  /// Squared distance from p_i of the farthest blocker that has hidden anything.
  double squareReach() const { return square_reach_; }

 private:
  Vec3 p_i_;
  std::array<Vec3, kMost> point_, offset_;
  std::array<double, kMost> square_;
  std::size_t count_ = 0;
  double square_reach_ = 0;
};

/// A point in the lune of p_i and p_j, that is nearer to both than they are to each other; -1 when there is none.
template <typename Points>
int blockerOf(const Points& points, const Vec3& p_i, const Vec3& p_j) {
  const double square = (p_j - p_i).squaredNorm();
  int found = -1;
  points.search(
      0.5 * (p_i + p_j),
      [&](const CellBounds& box, double) { return squareGap(box, p_i) >= square || squareGap(box, p_j) >= square; },
      [&](int k) {
        const Vec3& p = points.position(k);
        found = (p - p_i).squaredNorm() < square && (p - p_j).squaredNorm() < square ? k : -1;
        return found >= 0;
      });
  return found;
}

/// The neighbours of a position p_i in the relative neighbourhood graph of `points` and p_i: those that no other point
/// blocks, compared in doubles as they are. `self` is the index of p_i among the points, -1 when it is none of them.
/// Writes those of them that are asked for (`isAsked(index)`) to `neighbors`, ascending; any point may block. Returns
/// the squared distance (m^2) from p_i of the farthest blocker that it took to rule out the others: while no point
/// within that distance goes, none of those ruled out can become a neighbour. `blockers` may hold points already, such
/// as the neighbours of before: that makes it faster and changes nothing.
///
/// `Points` has `position(index)` and `search(towards, skip, visit)`: visits the indices of every box for which
/// `skip(box, square distance from towards to the box)` is false, nearer boxes first; ends when `visit(index)` returns
/// true.
template <typename Points, typename IsAsked>
double collectNeighbors(const Points& points, const Vec3& p_i, int self, IsAsked isAsked, Blockers& blockers,
                        std::vector<int>& neighbors) {
  neighbors.clear();
  points.search(
      p_i, [&](const CellBounds& box, double gap) { return blockers.hideBox(box, gap); },
      [&](int j) {
        const Vec3& p_j = points.position(j);
        if (j != self && !blockers.hidePoint(p_j, (p_j - p_i).squaredNorm())) {
          blockers.add(p_j);
          if (isAsked(j)) {
            neighbors.push_back(j);
          }
        }
        return false;
      });
  double square_reach = 0;
  std::erase_if(neighbors, [&](int j) {
    const Vec3& p_j = points.position(j);
    if (blockers.hidePoint(p_j, (p_j - p_i).squaredNorm())) {  // by one that was found later
      return true;
    }
    const int k = blockerOf(points, p_i, p_j);
    if (k >= 0) {
      square_reach = std::max(square_reach, (points.position(k) - p_i).squaredNorm());
    }
    return k >= 0;
  });
  std::sort(neighbors.begin(), neighbors.end());
  return std::max(square_reach, blockers.squareReach());
}

}  // namespace hgg
