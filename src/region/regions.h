#pragma once

#include "map/map.h"
#include "map/region.h"
#include "region/region_name.h"
#include "traversability/map_leaves.h"

namespace hgg {

/// Groups the confirmed things of a map, whose leaves must be in memory. Nothing but the graph is read: leaves and
/// where they were seen from. The same things give the same regions, in whatever order they came into the map.
Regions findRegions(const Map& map, const EdgeModel& model = {});
/// The same of a copy of what is in a map.
Regions findRegions(const MapLeaves& map, const ClassNames& names, const EdgeModel& model = {});

}  // namespace hgg
