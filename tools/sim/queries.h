#pragma once

#include <vector>

#include "sim/scene.h"
#include "truth/objects.h"
#include "truth/queries.h"

namespace hgg {

/// Phrases for things that were seen and stand there to the end, each with exactly one right answer by a clear margin.
/// Rivals are all things of the class that the world ever has, seen or not (a table's rivals are desks too); classes
/// with members that move by themselves are left out, and those whose name no one would say.
/// - "the ticket machine": the only one.
/// - "the largest table", "the smallest bin", "the tallest pole": spread (root of the covariance's trace) or height,
///   10 % ahead of the next in the world's geometry, and ahead in what was seen. None of trees, whose crowns are stuff.
/// - "the bench next to the tree": at most 1.5 m between the surfaces, and at least 2 m from every other bench to every
///   tree. "The chair closest to the plant": up to 5 m, only to the one of its class. For both the next candidate is at
///   least 1.5 times and 0.5 m farther; the answer is the nearest by centres as well, and no wall is between.
/// - "the bench farthest from the bus": 15 % ahead of the next, from the one of its class.
/// The last two kinds hold whether a tree is its trunk or has its crown, and whether "the table" may be a desk.
std::vector<TruthQuery> makeQueries(const Scene& scene, const std::vector<TruthObject>& seen);

}  // namespace hgg
