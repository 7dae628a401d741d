#pragma once

#include <vector>

#include "map/map.h"

namespace hgg {

/// Groups things that stand in the open, where no walls say what belongs together.
std::vector<std::vector<NodeId>> groupInTheOpen(const Map& map, const std::vector<NodeId>& ids);

}  // namespace hgg
