#pragma once

#include <vector>

#include "sim/scene.h"
#include "truth/objects.h"
#include "truth/queries.h"

namespace hgg {

/// Phrases for things that were seen and stand there to the end, each with exactly one right answer by a clear margin.
/// Rivals are all things of the class that the world ever has, seen or not (a table's rivals are desks too); classes
/// with members that move by themselves are left out.
/// - "the ticket machine": the only one.
/// - "the largest table", "the smallest bin", "the tallest pole": spread (root of the covariance's trace) or height,
///   10 % ahead of the next in the world's geometry, and ahead in what was seen.
/// - "the bench next to the tree", "the chair closest to the plant": the smallest distance of surfaces, with the next
///   candidate at least 1.5 times and 0.5 m farther; also nearest by centres, and no wall between. "Closest" only to
///   the one of its class.
/// - "the bench farthest from the bus": 15 % ahead of the next, from the one of its class.
std::vector<TruthQuery> makeQueries(const Scene& scene, const std::vector<TruthObject>& seen);

}  // namespace hgg
