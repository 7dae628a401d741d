#include "traversability/octomap_export.h"

#include <octomap/OcTree.h>

#include <sstream>

namespace hgg {
namespace {

std::unique_ptr<octomap::OcTree> treeOf(const VoxelGrid& voxels) {
  auto tree = std::make_unique<octomap::OcTree>(voxels.resolution());
  voxels.forEach([&](const Voxel& v, float log_odds) {
    const Vec3 p = voxels.centreOf(v);
    tree->setNodeValue(p.x(), p.y(), p.z(), log_odds, true);  // lazily: inner nodes once, below
  });
  tree->updateInnerOccupancy();
  return tree;
}

}  // namespace

std::string octomapBinary(const VoxelGrid& voxels) {
  const auto tree = treeOf(voxels);
  tree->toMaxLikelihood();
  tree->prune();
  std::ostringstream out;
  tree->writeBinaryConst(out);
  return std::move(out).str();
}

std::string octomapFull(const VoxelGrid& voxels) {
  const auto tree = treeOf(voxels);
  tree->prune();
  std::ostringstream out;
  tree->write(out);
  return std::move(out).str();
}

}  // namespace hgg
