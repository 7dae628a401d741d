#include "map/node.h"

#include <algorithm>
#include <cstdlib>

#include "core/position_uncertainty.h"
#include "core/se3.h"

namespace hgg {

const Leaves& leavesOf(const MapNode& node) {
  if (node.geometry == nullptr) {
    std::abort();  // a caller did not bring back what it reads
  }
  return *node.geometry;
}

Tile tileOf(const Vec3& p_map, double tile_size) {
  const Eigen::Array3i t = (p_map / tile_size + Vec3::Constant(0.5)).array().floor().cast<int>();
  return {t[0], t[1], t[2]};
}

void moveBy(const Pose& move, double tile_size, MapNode& node) {
  node.belief = transform(move, node.belief);
  node.T_map_object = orthonormalized(move * node.T_map_object);
  node.tile = node.stuff && tile_size > 0 ? tileOf(node.belief.mean, tile_size) : node.tile;
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
