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

/// Dirichlet belief over the class of what is at a place: `views` counts, for each class, the views in which the place
/// was labelled so. A view is one frame's observation of one object; a partial one counts as a part.
struct ClassBelief {
  ClassWeights views;
};

/// Adds one more view, or the views of another belief about the same place. Once there are more than a thousand, all
/// are scaled down to a thousand: old views fade, so that the belief can still change.
void addViews(ClassBelief& belief, const ClassWeights& views);

/// The class with the most views, that with the smaller id of two with equally many; `fallback` without views.
ClassId likeliestClass(const ClassBelief& belief, ClassId fallback);

/// Probability of each class under the belief; empty without views.
ClassWeights classProbabilities(const ClassBelief& belief);

/// Probability that there is a thing of class `label` at the place, n / (n + m / 3 + c), where n views found it and m
/// found something else. c = 2 * 400 / (400 + points) is a prior of clutter, which fades with the number of the thing's
/// points. It is below 0.5 for a first sighting of few points, and where fewer than one view in four finds the thing.
double existence(const ClassBelief& belief, ClassId label, double points);

}  // namespace hgg
