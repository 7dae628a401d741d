#include "traversability/octomap_export.h"

#include <fmt/format.h>
#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <sstream>

#include "map/export.h"

namespace hgg {
namespace {

/// Columns of voxels: those from the first to before the last corner.
struct Columns {
  std::array<std::int32_t, 2> first{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::min()};
  std::array<std::int32_t, 2> last{std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::max()};

  bool contain(const Voxel& v) const {
    return v[0] >= first[0] && v[0] < last[0] && v[1] >= first[1] && v[1] < last[1];
  }
};

std::unique_ptr<octomap::OcTree> treeOf(const VoxelGrid& voxels, const Columns& columns = {}) {
  auto tree = std::make_unique<octomap::OcTree>(voxels.resolution());
  voxels.forEach([&](const Voxel& v, float log_odds) {
    if (!columns.contain(v)) {
      return;
    }
    const Vec3 p = voxels.centreOf(v);
    tree->setNodeValue(p.x(), p.y(), p.z(), log_odds, true);  // lazily: inner nodes once, below
  });
  tree->updateInnerOccupancy();
  return tree;
}

/// A node and all below it, as OcTreeBaseImpl::writeData does.
template <typename Tree, typename Node>
void writeNodes(const Tree& tree, const Node* node, std::ostream& out) {
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
std::string withHead(const char* first_lines, const octomap::AbstractOcTree& tree, const std::string& data) {
  return fmt::format("{}id {}\nsize {}\nres {}\ndata\n", first_lines, tree.getTreeType(), tree.size(),
                     tree.getResolution()) +
         data;
}

constexpr char kFullHead[] =
    "# Octomap OcTree file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n";

/// Makes one node of eight that are the same. ColorOcTree's own function goes by occupancy alone and mixes the colours.
void pruneSame(octomap::ColorOcTree& tree, octomap::ColorOcTreeNode* node) {
  unsigned same = 0;
  for (unsigned k = 0; k < 8; ++k) {
    if (!tree.nodeChildExists(node, k)) {
      continue;
    }
    octomap::ColorOcTreeNode* child = tree.getNodeChild(node, k);
    pruneSame(tree, child);
    const octomap::ColorOcTreeNode* first = tree.nodeChildExists(node, 0) ? tree.getNodeChild(node, 0) : nullptr;
    same += first != nullptr && !tree.nodeHasChildren(child) && child->getLogOdds() == first->getLogOdds() &&
                    child->getColor() == first->getColor()
                ? 1
                : 0;
  }
  if (same == 8) {
    tree.pruneNode(node);
  }
}

std::string binaryOf(const VoxelGrid& voxels, const Columns& columns) {
  const auto tree = treeOf(voxels, columns);
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

/// Halves the longer side until each part is small enough.
void appendParts(const VoxelGrid& voxels, const Columns& columns, std::size_t most_bytes,
                 std::vector<std::string>& parts) {
  const std::array<std::int32_t, 2> size{columns.last[0] - columns.first[0], columns.last[1] - columns.first[1]};
  const std::size_t axis = size[0] >= size[1] ? 0 : 1;
  std::string bytes = binaryOf(voxels, columns);
  if (bytes.size() <= most_bytes || size[axis] <= 1) {
    parts.push_back(std::move(bytes));
    return;
  }
  Columns first = columns, second = columns;
  first.last[axis] = second.first[axis] = columns.first[axis] + size[axis] / 2;
  appendParts(voxels, first, most_bytes, parts);
  appendParts(voxels, second, most_bytes, parts);
}

}  // namespace

std::string octomapBinary(const VoxelGrid& voxels) { return binaryOf(voxels, {}); }

std::vector<std::string> octomapParts(const VoxelGrid& voxels, std::size_t most_bytes) {
  constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  Columns all{{kFar, kFar}, {-kFar, -kFar}};
  voxels.forEach([&](const Voxel& v, float) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      all.first[axis] = std::min(all.first[axis], v[axis]), all.last[axis] = std::max(all.last[axis], v[axis] + 1);
    }
  });
  std::vector<std::string> parts;
  if (all.first[0] < all.last[0]) {
    appendParts(voxels, all, most_bytes, parts);
  }
  return parts;
}

std::string octomapFull(const VoxelGrid& voxels) {
  const auto tree = treeOf(voxels);
  tree->prune();
  std::ostringstream data;
  if (tree->getRoot() != nullptr) {
    writeNodes(*tree, tree->getRoot(), data);
  }
  return withHead(kFullHead, *tree, std::move(data).str());
}

std::string octomapColoured(const VoxelGrid& voxels) {
  octomap::ColorOcTree tree(voxels.resolution());
  voxels.forEach([&](const Voxel& v, float log_odds) {
    const Vec3 p = voxels.centreOf(v);
    octomap::ColorOcTreeNode* node = tree.setNodeValue(p.x(), p.y(), p.z(), log_odds, true);
    if (log_odds > 0) {
      const std::array<std::uint8_t, 3> rgb = colourOf(voxels.labelOf(v));
      node->setColor(rgb[0], rgb[1], rgb[2]);
    }
  });
  tree.updateInnerOccupancy();
  std::ostringstream data;
  if (tree.getRoot() != nullptr) {
    pruneSame(tree, tree.getRoot());
    writeNodes(tree, tree.getRoot(), data);
  }
  return withHead(kFullHead, tree, std::move(data).str());
}

}  // namespace hgg
