#pragma once

#include <vector>

#include "map/map.h"
#include "traversability/map_leaves.h"
#include "traversability/sample.h"

namespace hgg {

/// The surfaces of stuff, by what they are to somebody who walks.
struct StuffSurfaces {
  std::vector<LeafSheet> ground, standing, overhead;
};

/// Those of confirmed stuff that are flat and have as many points as what is around them.
StuffSurfaces surfacesOf(const MapLeaves& map);

/// Keeps what lies where a roof was seen, or beside it: in the open no walls make rooms, and to look would take long.
void keepUnderRoofs(StuffSurfaces& surfaces);

}  // namespace hgg
