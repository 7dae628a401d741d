#pragma once

#include "core/class_belief.h"
#include "map/local_graph.h"

namespace hgg {

/// Views that a thing starts with as the stuff in whose plane it lies: as many as a stretch of wrong labels may last,
/// for the share of its points that are in the plane which the frame's stuff of that class makes around it. It speaks
/// against a patch of wall, road or meadow that was never seen before, and delays what really hangs on a wall by some
/// frames: all views of one stretch are one opinion. Empty for what stands clear of every such plane. `sigma_floor`:
/// noise of the points, m.
ClassWeights viewsOfPlane(const LocalGraph& local, const LocalObject& object, double sigma_floor);

}  // namespace hgg
