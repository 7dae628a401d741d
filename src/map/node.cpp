#include "map/node.h"

#include <algorithm>

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
  constexpr double kViewShare = 0.7, kShare = 0.06;   // of the extent: of one view, and of all
  constexpr double kViewNoise = 0.05, kNoise = 0.02;  // m
  const double views = std::max(node.views, 1);
  const double per_point = 1 / std::max(node.belief.kappa, 1.0) + kViewShare * kViewShare / views + kShare * kShare;
  return per_point * node.belief.cov + (kViewNoise * kViewNoise / views + kNoise * kNoise) * Mat3::Identity();
}

double existenceOf(const MapNode& node) {
  return node.stuff ? 1 : existence(node.classes, node.label, node.belief.kappa);
}

bool isConfirmed(const MapNode& node) { return existenceOf(node) >= 0.5; }

}  // namespace hgg
