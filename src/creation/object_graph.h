#pragma once

#include <vector>

#include "config.h"
#include "frame/frame.h"
#include "map/local_graph.h"

namespace hgg {

/// Creation: one frame -> local graph G_t in the body frame. T_map_body is the predicted pose; it only lays the stuff
/// tiles.
LocalGraph createLocalGraph(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                            const Config& config);

}  // namespace hgg
