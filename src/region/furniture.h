#pragma once

#include "region/floor_plan.h"

namespace hgg {

/// Takes away what is called a wall and is none: what is less than a metre across, as are the edges of furniture and
/// points with a wrong label, and what is smaller than a room and stands alone, as pillars, counters and stairs do.
void removeFurniture(FloorPlan& plan);

}  // namespace hgg
