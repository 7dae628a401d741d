#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "core/types.h"

namespace hgg {

/// A point of the labelled reference cloud, map frame. `object` = the id of gt_objects.json (stuff has ids too).
struct CloudPoint {
  float x, y, z;
  ClassId label;
  std::uint32_t object;
};

/// cloud.ply: binary little-endian PLY, element vertex: float x, float y, float z, ushort label, uint object.
/// Returns an error line, empty when done.
std::string writeCloud(const std::vector<CloudPoint>& cloud, const std::filesystem::path& path);
/// Reads what writeCloud() writes.
Result<std::vector<CloudPoint>> readCloud(const std::filesystem::path& path);

}  // namespace hgg
