#pragma once

#include "mapper.h"
#include "publish/messages.h"

namespace hgg {

/// What a step changed: its created, changed, moved and removed nodes, those whose edges a neighbour's change has
/// changed, and all edges with an end among them. What a closed loop does to edges is said over the frames after it.
GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report);

/// The whole graph at its present revision, for late joiners. `utime_us` is the time of the newest frame.
GraphUpdate completeGraph(const Mapper& mapper, Micros utime_us);

}  // namespace hgg
