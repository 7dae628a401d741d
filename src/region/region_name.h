#pragma once

#include <map>
#include <string>

#include "map/region.h"
#include "traversability/map_leaves.h"

namespace hgg {

using ClassNames = std::map<ClassId, std::string>;

/// What people would call the place where these things are: "kitchen" where there are a fridge and a sink; else what
/// there is most of, "row of cars". Empty where the map knows no names.
std::string regionName(const MapLeaves& map, const ClassNames& names, const Region& region);

}  // namespace hgg
