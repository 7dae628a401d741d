#pragma once

#include <string>

#include "traversability/voxels.h"

namespace hgg {

/// An OctoMap of the voxels. Binary (.bt, the data of octomap.raw_t with its header): occupied, free or unknown.
std::string octomapBinary(const VoxelGrid& voxels);
/// With probabilities (.ot).
std::string octomapFull(const VoxelGrid& voxels);

}  // namespace hgg
