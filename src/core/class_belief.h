#pragma once

#include <utility>
#include <vector>

#include "core/types.h"

namespace hgg {

/// An amount for each class, ascending by class, none twice.
using ClassWeights = std::vector<std::pair<ClassId, float>>;

void addWeight(ClassWeights& weights, ClassId label, double amount);
double weightOf(const ClassWeights& weights, ClassId label);
double sumOf(const ClassWeights& weights);

/// Dirichlet belief over what is at a place: `views` counts the views that took it for each class.
struct ClassBelief {
  ClassWeights views;
};

/// Adds what one more view (or another belief about the same place) took it for. Old views fade once there are more
/// than a thousand, so that the belief can still change its mind.
void addViews(ClassBelief& belief, const ClassWeights& views);

/// The class most views took the place for, the smaller id of two; `fallback` without views.
ClassId likeliestClass(const ClassBelief& belief, ClassId fallback);

/// Probability of each class under the belief; empty without views.
ClassWeights classProbabilities(const ClassBelief& belief);

/// Probability that there is a thing of class `label` at the place, n / (n + m / 3 + c): n views found it, m found
/// something else, and a prior of clutter c that fades with the thing's `points`. Below 0.5 for a first sighting of a
/// few points, and where fewer than one view in four finds it.
double existence(const ClassBelief& belief, ClassId label, double points);

}  // namespace hgg
