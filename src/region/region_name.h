#pragma once

#include <string>
#include <vector>

#include "map/map.h"

namespace hgg {

/// What people would call the place where these things are: "kitchen" where there are a fridge and a sink; else what
/// there is most of, "cars".
std::string regionName(const Map& map, const std::vector<NodeId>& objects);

}  // namespace hgg
