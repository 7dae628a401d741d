#include "map/node.h"

#include <algorithm>

#include "core/position_uncertainty.h"

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

Tile tileOf(const Vec3& p_map, double tile_size) {
  const Eigen::Array3i t = (p_map / tile_size + Vec3::Constant(0.5)).array().floor().cast<int>();
  return {t[0], t[1], t[2]};
}

Mat3 positionCovariance(const MapNode& node) {
  return positionCovariance(kPositionWithinDrive, node.belief.cov, std::max(node.belief.kappa, 1.0),
                            std::max(node.views, 1));
}

double existenceOf(const MapNode& node) {
  return node.stuff ? 1 : existence(node.classes, node.label, node.belief.kappa);
}

bool isConfirmed(const MapNode& node) { return existenceOf(node) >= 0.5; }

}  // namespace hgg
