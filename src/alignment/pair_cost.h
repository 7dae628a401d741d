#pragma once

#include "config.h"
#include "core/belief.h"

namespace hgg {

/// The geometric part of the cost of a pair of things, m. Wasserstein is the 2-Wasserstein distance of the two
/// Gaussians (eq. wass). The other two are for an evaluation to compare it with: centroid is the distance of the means,
/// IoU the share of their axis-parallel boxes that they do not have in common, times `apart` (m), which is then the
/// cost of boxes that do not meet. `sigma_floor` (m) keeps the boxes of flat things from vanishing.
double pairCost(const Belief& seen, const Belief& known, PairCost kind, double sigma_floor, double apart);

}  // namespace hgg
