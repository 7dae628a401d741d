#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/types.h"

namespace hgg {

/// An axis-aligned box; empty when lo > hi.
struct Bounds {
  Vec3 lo = Vec3::Constant(1e300), hi = Vec3::Constant(-1e300);
};
Bounds join(const Bounds& a, const Bounds& b);

/// A ray prepared for many boxes.
struct RaySlabs {
  Vec3 origin, inverse;  // inverse of the direction, bounded so that 0 * inverse stays a number
  RaySlabs(const Vec3& ray_origin, const Vec3& direction);

  /// Where the ray enters the box, 0 from inside; infinity when it misses it or would only meet it behind itself.
  double entry(const Bounds& box) const {
    double enter = 0.0, leave = 1e300;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.lo[axis] - origin[axis]) * inverse[axis];
      const double b = (box.hi[axis] - origin[axis]) * inverse[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave ? enter : std::numeric_limits<double>::infinity();
  }
};

/// A tree of boxes around items, so that a ray meets few of them. Boxes are grown by a hair, so that rounding never
/// hides an item.
class Bvh {
 public:
  Bvh() = default;
  /// Items are known by their index.
  explicit Bvh(const std::vector<Bounds>& items);

  /// Calls test(item) for every item whose box the ray enters before `nearest`, near boxes first. `test` may lower
  /// `nearest`.
  template <typename Test>
  void visit(const RaySlabs& ray, const double& nearest, Test&& test) const;

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t first = 0;  // leaf: into items_; inner node: its second child (the first is the next node)
    std::uint32_t count = 0;  // items of a leaf; 0 = inner node
  };
  void build(const std::vector<Bounds>& items, std::uint32_t first, std::uint32_t count, int depth);

  static constexpr int kMaxDepth = 60;
  std::vector<Node> nodes_;  // the root is the first
  std::vector<std::uint32_t> items_;
};

template <typename Test>
void Bvh::visit(const RaySlabs& ray, const double& nearest, Test&& test) const {
  struct Waiting {
    std::uint32_t node;
    double entry;
  };
  std::array<Waiting, kMaxDepth + 2> stack;
  std::size_t waiting = 0;
  if (!nodes_.empty()) {
    stack[waiting++] = {0, ray.entry(nodes_[0].bounds)};
  }
  while (waiting > 0) {
    const Waiting top = stack[--waiting];
    if (!(top.entry <= nearest) || top.entry > 1e299) {
      continue;
    }
    const Node& node = nodes_[top.node];
    for (std::uint32_t i = 0; i < node.count; ++i) {
      test(items_[node.first + i]);
    }
    if (node.count == 0) {
      Waiting near{top.node + 1, ray.entry(nodes_[top.node + 1].bounds)};
      Waiting far{node.first, ray.entry(nodes_[node.first].bounds)};
      if (far.entry < near.entry) {
        std::swap(near, far);
      }
      stack[waiting++] = far;
      stack[waiting++] = near;
    }
  }
}

}  // namespace hgg
