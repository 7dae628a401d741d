#include "map/geometry.h"

#include <utility>

#include "core/neighborhood.h"

namespace hgg {

Leaf packLeaf(const Belief& b) {
  Leaf leaf;
  for (std::size_t k = 0; k < 3; ++k) {
    leaf.mean[k] = static_cast<float>(b.mean[static_cast<Eigen::Index>(k)]);
  }
  leaf.cov = {static_cast<float>(b.cov(0, 0)), static_cast<float>(b.cov(1, 1)), static_cast<float>(b.cov(2, 2)),
              static_cast<float>(b.cov(0, 1)), static_cast<float>(b.cov(0, 2)), static_cast<float>(b.cov(1, 2))};
  leaf.kappa = static_cast<float>(b.kappa);
  return leaf;
}

Belief unpackLeaf(const Leaf& leaf) {
  Belief b;
  b.mean = Vec3(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
  b.cov << leaf.cov[0], leaf.cov[3], leaf.cov[4],  //
      leaf.cov[3], leaf.cov[1], leaf.cov[5],       //
      leaf.cov[4], leaf.cov[5], leaf.cov[2];
  b.kappa = leaf.kappa;
  return b;
}

std::vector<std::pair<int, int>> geometryEdges(std::span<const Belief> leaves) {
  std::vector<Vec3> means;
  means.reserve(leaves.size());
  for (const Belief& leaf : leaves) {
    means.push_back(leaf.mean);
  }
  return relativeNeighborhood(means);
}

GeometryBlock shareLeaves(Leaves leaves) {
  return leaves.empty() ? noLeaves() : std::make_shared<const Leaves>(std::move(leaves));
}

const GeometryBlock& noLeaves() {
  static const GeometryBlock kNone = std::make_shared<const Leaves>();
  return kNone;
}

}  // namespace hgg
