#include "core/neighborhood.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace hgg {
namespace {

/// A k-d tree over the points as nested ranges of `order`; boxes are tight. It is our own because the searches below
/// prune whole boxes by a condition of the caller, which nanoflann's interface (nearest k, or a radius) does not offer.
class PointTree {
 public:
  struct Node {
    Vec3 low, high;
    int begin = 0, end = 0;
    int right = 0;  // the left child follows its parent; 0: a leaf
  };

  explicit PointTree(std::span<const Vec3> points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.reserve(points.size() / 2 + 1);
    if (!points.empty()) {
      build(0, static_cast<int>(points.size()));
    }
  }

  /// Visits the points of every box for which `skip(box, square distance from `towards` to the box)` is false, nearer
  /// boxes first; ends when `visit(index)` returns true and then returns true.
  template <typename Skip, typename Visit>
  bool search(const Vec3& towards, Skip skip, Visit visit) const {
    return !nodes_.empty() && search(0, squareGap(nodes_[0], towards), towards, skip, visit);
  }

  /// Squared distance from p to a box.
  static double squareGap(const Node& box, const Vec3& p) {
    return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).squaredNorm();
  }

 private:
  static constexpr int kLeafPoints = 12;

  void build(int begin, int end) {
    Node node{point(begin), point(begin), begin, end};
    for (int k = begin; k < end; ++k) {
      node.low = node.low.cwiseMin(point(k)), node.high = node.high.cwiseMax(point(k));
    }
    const std::size_t self = nodes_.size();
    nodes_.push_back(node);
    if (end - begin <= kLeafPoints) {
      return;
    }
    Eigen::Index axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
      return points_[static_cast<std::size_t>(a)][axis] < points_[static_cast<std::size_t>(b)][axis];
    });
    build(begin, middle);
    nodes_[self].right = static_cast<int>(nodes_.size());
    build(middle, end);
  }

  template <typename Skip, typename Visit>
  bool search(int n, double gap, const Vec3& towards, Skip& skip, Visit& visit) const {
    const Node& node = nodes_[static_cast<std::size_t>(n)];
    if (skip(node, gap)) {
      return false;
    }
    if (node.right == 0) {
      return std::any_of(order_.begin() + node.begin, order_.begin() + node.end, visit);
    }
    int first = n + 1, second = node.right;
    double first_gap = squareGap(nodes_[static_cast<std::size_t>(first)], towards);
    double second_gap = squareGap(nodes_[static_cast<std::size_t>(second)], towards);
    if (second_gap < first_gap) {
      std::swap(first, second), std::swap(first_gap, second_gap);
    }
    return search(first, first_gap, towards, skip, visit) || search(second, second_gap, towards, skip, visit);
  }

  const Vec3& point(int k) const { return points_[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])]; }

  std::span<const Vec3> points_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

/// The nearest points of i, nearest first, with their offsets from it. They block nearly everything i is not a
/// neighbour of.
struct Blockers {
  static constexpr std::size_t kMost = 8;
  std::array<Vec3, kMost> point, offset;
  std::array<double, kMost> square;
  std::size_t count = 0;

  void add(const Vec3& p, const Vec3& d) {
    const double d_square = d.squaredNorm();
    if (count == kMost && d_square >= square.back()) {
      return;
    }
    std::size_t slot = count < kMost ? count++ : kMost - 1;
    for (; slot > 0 && square[slot - 1] > d_square; --slot) {
      square[slot] = square[slot - 1], offset[slot] = offset[slot - 1], point[slot] = point[slot - 1];
    }
    square[slot] = d_square, offset[slot] = d, point[slot] = p;
  }
};

Blockers nearestPoints(std::span<const Vec3> points, const PointTree& tree, int i) {
  const Vec3& p_i = points[static_cast<std::size_t>(i)];
  Blockers near;
  tree.search(
      p_i,
      [&](const PointTree::Node&, double gap) { return near.count == Blockers::kMost && gap >= near.square.back(); },
      [&](int k) {
        if (k != i) {
          near.add(points[static_cast<std::size_t>(k)], points[static_cast<std::size_t>(k)] - p_i);
        }
        return false;
      });
  return near;
}

/// True when some blocker comes between i and every point of the box: all of the box is nearer to the blocker than to
/// i, and farther from i than the blocker is. The margins keep points that tie in exact arithmetic.
bool blockBox(const Blockers& near, const PointTree::Node& box, double gap, const Vec3& p_i) {
  const Vec3 low = box.low - p_i, high = box.high - p_i;
  const double margin = 1e-12 * (low.squaredNorm() + high.squaredNorm());
  for (std::size_t k = 0; k < near.count && near.square[k] < gap * (1 - 1e-12); ++k) {
    const Vec3& n = near.offset[k];
    const double nearest =
        n.cwiseProduct(low).cwiseMin(n.cwiseProduct(high)).sum();  // smallest (q - p_i) . n in the box
    if (2 * nearest > near.square[k] + margin) {
      return true;
    }
  }
  return false;
}

bool blockPoint(const Blockers& near, const Vec3& p, double square_ij) {
  for (std::size_t k = 0; k < near.count && near.square[k] < square_ij; ++k) {
    if ((near.point[k] - p).squaredNorm() < square_ij) {
      return true;
    }
  }
  return false;
}

/// Points j >= first that none of the nearest points of i blocks: a superset of i's neighbours among them, ascending.
void collectCandidates(std::span<const Vec3> points, const PointTree& tree, int i, int first,
                       std::vector<int>& candidates) {
  const Vec3& p_i = points[static_cast<std::size_t>(i)];
  const Blockers near = nearestPoints(points, tree, i);
  candidates.clear();
  tree.search(
      p_i, [&](const PointTree::Node& box, double gap) { return blockBox(near, box, gap, p_i); },
      [&](int j) {
        const Vec3& p_j = points[static_cast<std::size_t>(j)];
        if (j >= first && j != i && !blockPoint(near, p_j, (p_j - p_i).squaredNorm())) {
          candidates.push_back(j);
        }
        return false;
      });
  std::sort(candidates.begin(), candidates.end());
}

/// True when some point lies in the lune of i and j.
bool isBlocked(std::span<const Vec3> points, const PointTree& tree, const Vec3& p_i, const Vec3& p_j) {
  const double square = (p_j - p_i).squaredNorm();
  return tree.search(
      0.5 * (p_i + p_j),
      [&](const PointTree::Node& box, double) {
        return PointTree::squareGap(box, p_i) >= square || PointTree::squareGap(box, p_j) >= square;
      },
      [&](int k) {
        const Vec3& p = points[static_cast<std::size_t>(k)];
        return (p - p_i).squaredNorm() < square && (p - p_j).squaredNorm() < square;
      });
}

/// Neighbours j >= first of i, ascending.
void collectNeighbors(std::span<const Vec3> points, const PointTree& tree, int i, int first,
                      std::vector<int>& neighbors) {
  collectCandidates(points, tree, i, first, neighbors);
  const Vec3& p_i = points[static_cast<std::size_t>(i)];
  std::erase_if(neighbors, [&](int j) { return isBlocked(points, tree, p_i, points[static_cast<std::size_t>(j)]); });
}

}  // namespace

std::vector<std::pair<int, int>> relativeNeighborhood(std::span<const Vec3> points) {
  const PointTree tree(points);
  std::vector<std::pair<int, int>> edges;
  std::vector<int> later;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    collectNeighbors(points, tree, i, i + 1, later);
    for (const int j : later) {
      edges.emplace_back(i, j);
    }
  }
  return edges;
}

std::vector<std::vector<int>> relativeNeighborsOf(std::span<const Vec3> points, std::span<const int> of) {
  const PointTree tree(points);
  std::vector<std::vector<int>> neighbors(of.size());
  for (std::size_t k = 0; k < of.size(); ++k) {
    collectNeighbors(points, tree, of[k], 0, neighbors[k]);
  }
  return neighbors;
}

}  // namespace hgg
