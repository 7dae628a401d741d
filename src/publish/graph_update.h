#pragma once

#include "mapper.h"
#include "publish/messages.h"

namespace hgg {

/// What a step changed: its created, changed, moved and removed nodes, and the edges with an end among those that are
/// there. Edges between untouched nodes can come and go with a neighbour; completeGraph() carries those.
GraphUpdate changedGraph(const Mapper& mapper, const StepReport& report);

/// The whole graph at its present revision, for late joiners. `utime_us` is the time of the newest frame.
GraphUpdate completeGraph(const Mapper& mapper, Micros utime_us);

}  // namespace hgg
