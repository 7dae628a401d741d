#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "map/file.h"
#include "map/region.h"

namespace hgg {

/// Graph JSON, version 1 (docs/file-format.md): objects with their geometry in the map frame, edges, keyframes,
/// and the regions that were found in it.
std::string exportJson(const StoredMap& stored, const Regions& regions = {});

/// Binary PLY with one vertex a leaf: mean, normal (its flattest axis), standard deviations along its axes (s0 <= s1 <=
/// s2), kappa, object id, label and a colour per class.
std::string exportPly(const StoredMap& stored);

/// A stable colour (red, green, blue) for each class: hues by golden-ratio steps.
std::array<std::uint8_t, 3> colourOf(ClassId label);

}  // namespace hgg
