#pragma once

#include <span>
#include <vector>

#include "core/belief.h"

namespace hgg {

/// Groups of things in the open, where no walls say what belongs together: rows, clusters, what lines a square. From
/// the closest pair on, groups become one unless the gap between them is more than twice the usual gap inside of
/// either. So no distance is set: bicycles in a rack are half a metre apart, trees of an avenue ten. Indices into
/// `things`, each group ascending, the groups by their first. Does not depend on the order of the things but for that.
std::vector<std::vector<int>> groupInTheOpen(std::span<const Belief> things);

/// How far apart two things are that fill boxes with these covariances, m; at least half a metre, below which gaps are
/// taken to be equal. Horizontally.
double gapBetween(const Belief& a, const Belief& b);

}  // namespace hgg
