#pragma once

#include <string>

#include "map/file.h"

namespace hgg {

/// Graph JSON, version 1 (docs/file-format.md): objects with their geometry in the map frame, edges, keyframes.
std::string exportJson(const StoredMap& stored);

/// Binary PLY with one vertex a leaf: mean, normal (its flattest axis), standard deviations along its axes (s0 <= s1 <=
/// s2), kappa, object id, label and a colour per class.
std::string exportPly(const StoredMap& stored);

}  // namespace hgg
