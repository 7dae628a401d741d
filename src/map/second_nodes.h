#pragma once

#include "config.h"
#include "core/classes.h"
#include "map/map.h"

namespace hgg {

/// Merges all things of the map that are one object with another of their class (map/same_thing.h), active or not: what
/// no frame has touched since it grew, and what was met again from so far along the way that frames were not matched
/// with it. Of two that were never active together the drift between them must be smaller than what clustering bridges.
/// The older node keeps its id. For the end of a drive, when all of the map is in memory: a loop that is closed later
/// is recognised by what each pass has of its own. Cost grows with the map. The update is a sequel to the last frame.
MapUpdate mergeSecondNodes(const Map& map, const ClassTable& classes, const Config& config);

}  // namespace hgg
