#pragma once

#include <vector>

#include "config.h"
#include "frame/frame.h"
#include "map/local_graph.h"

namespace hgg {

/// Creation: turns one frame into its local graph G_t, in the body frame. T_map_body is the predicted pose; it is only
/// used to lay the tiles of stuff.
LocalGraph createLocalGraph(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                            const Config& config);

}  // namespace hgg
