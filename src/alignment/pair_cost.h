#pragma once

#include "config.h"
#include "core/belief.h"

namespace hgg {

/// The geometric part of the cost of a pair of things, m: the 2-Wasserstein distance of the two Gaussians (eq. wass).
/// By `ablation.cost` what an evaluation holds against it: the distance of the means ("centroid"), or the share of
/// their axis-parallel boxes that they do not have in common ("iou"), scaled so that boxes apart never pass the gate.
double pairCost(const Belief& seen, const Belief& known, const Config& config);

}  // namespace hgg
