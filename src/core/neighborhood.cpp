#include "core/neighborhood.h"

#include <algorithm>
#include <numeric>

#include "core/relative_neighbors.h"

namespace hgg {
namespace {

/// A k-d tree over the points as nested ranges of `order`; boxes are tight. It is our own because the searches below
/// prune whole boxes by a condition of the caller, which nanoflann's interface (nearest k, or a radius) does not offer.
class PointTree {
 public:
  struct Node : CellBounds {
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

  const Vec3& position(int i) const { return points_[static_cast<std::size_t>(i)]; }

 private:
  static constexpr int kLeafPoints = 12;

  void build(int begin, int end) {
    Node node{{point(begin), point(begin)}, begin, end};
    for (int k = begin; k < end; ++k) {
      node.extend(point(k));
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

  const Vec3& point(int k) const { return position(order_[static_cast<std::size_t>(k)]); }

  std::span<const Vec3> points_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<std::pair<int, int>> relativeNeighborhood(std::span<const Vec3> points) {
  const PointTree tree(points);
  std::vector<std::pair<int, int>> edges;
  std::vector<int> later;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    Blockers blockers(tree.position(i));
    collectNeighbors(
        tree, tree.position(i), i, [&](int j) { return j > i; }, blockers, later);
    for (const int j : later) {
      edges.emplace_back(i, j);
    }
  }
  return edges;
}

}  // namespace hgg
