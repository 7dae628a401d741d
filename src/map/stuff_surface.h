#pragma once

#include "core/class_belief.h"
#include "map/local_graph.h"

namespace hgg {

/// Views in a stretch of wrong labels: two seconds at 10 Hz. All views of one stretch are one opinion.
/// docs/experiments.md, "Confused surfaces", has what more and fewer do.
inline constexpr double kStretchOfWrongLabels = 20;

/// Views that a thing starts with as the stuff in whose plane it lies: as many as a stretch of wrong labels may last,
/// for the share of its points that are in the plane which the frame's stuff of that class makes around it. It speaks
/// against a patch of wall, road or meadow that was never seen before, and delays what really hangs on a wall by some
/// frames. Empty for what stands clear of every such plane. `sigma_floor`:
/// noise of the points, m.
ClassWeights viewsOfPlane(const LocalGraph& local, const LocalObject& object, double sigma_floor);

}  // namespace hgg
