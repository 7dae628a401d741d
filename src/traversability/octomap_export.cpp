#include "traversability/octomap_export.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <memory>
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

/// A node and all below it, as OcTreeBaseImpl::writeData does.
void writeNodes(const octomap::OcTree& tree, const octomap::OcTreeNode* node, std::ostream& out) {
  node->writeData(out);
  unsigned char children = 0;
  for (unsigned k = 0; k < 8; ++k) {
    children = static_cast<unsigned char>(children | (tree.nodeChildExists(node, k) ? 1U << k : 0U));
  }
  out.put(static_cast<char>(children));
  for (unsigned k = 0; k < 8; ++k) {
    if (tree.nodeChildExists(node, k)) {
      writeNodes(tree, tree.getNodeChild(node, k), out);
    }
  }
}

/// OctoMap's own functions for whole files and for all nodes print what they do, so the head is written here.
std::string withHead(const char* first_lines, const octomap::OcTree& tree, const std::string& data) {
  return fmt::format("{}id {}\nsize {}\nres {}\ndata\n", first_lines, tree.getTreeType(), tree.size(),
                     tree.getResolution()) +
         data;
}

}  // namespace

std::string octomapBinary(const VoxelGrid& voxels) {
  const auto tree = treeOf(voxels);
  tree->toMaxLikelihood();
  tree->prune();
  std::ostringstream data;
  if (tree->getRoot() != nullptr) {
    tree->writeBinaryNode(data, tree->getRoot());
  }
  return withHead(
      "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n",
      *tree, std::move(data).str());
}

std::string octomapFull(const VoxelGrid& voxels) {
  const auto tree = treeOf(voxels);
  tree->prune();
  std::ostringstream data;
  if (tree->getRoot() != nullptr) {
    writeNodes(*tree, tree->getRoot(), data);
  }
  return withHead(
      "# Octomap OcTree file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n", *tree,
      std::move(data).str());
}

}  // namespace hgg
