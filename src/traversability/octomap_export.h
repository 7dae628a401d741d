#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "traversability/voxels.h"

namespace hgg {

/// An OctoMap of the voxels in the bytes of OcTree::writeBinaryConst, head included (.bt, and the data of
/// octomap.raw_t): occupied, free or unknown.
std::string octomapBinary(const VoxelGrid& voxels);
/// The same as several trees that lie side by side, none larger than `most_bytes` but for a single column of voxels.
std::vector<std::string> octomapParts(const VoxelGrid& voxels, std::size_t most_bytes);
/// With probabilities (.ot).
std::string octomapFull(const VoxelGrid& voxels);
/// With probabilities, and occupied voxels in the colour of their class (a ColorOcTree, .ot): VoxelOptions::classes.
std::string octomapColoured(const VoxelGrid& voxels);

}  // namespace hgg
