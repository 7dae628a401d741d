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
  float seen_through = 0;  // views that have seen through the place since it was last seen to be taken
  float passed = 0;        // views that passed a thing which they found: what it lets through
};

/// Adds one more view, or the views of another belief about the same place. Once there are more than a thousand, all
/// are scaled down to a thousand: old views fade, so that the belief can still change.
void addViews(ClassBelief& belief, const ClassWeights& views);

/// What one frame sees at the place of a thing, in views.
struct PlaceView {
  ClassWeights labels;  // where it is taken, by class
  double taken = 0;     // where beams end, whatever their label and if only a few: no less than the labels' sum
  double through = 0;   // where beams pass that would have hit the thing
  double is_found = 0;  // weight of the frame where it has the thing as an object of its own, wherever its points are
};

/// Adds what a frame sees at the place of a thing of class `own`. Its labels count as above. Passing beams count as far
/// as they are more than the thing lets through, which is known from the views that found it and passed it as well
/// (leaves, a grille, a pole beside which beams pass). A view that finds it takes as large a share off of all that
/// spoke of free space before.
void addPlaceView(ClassBelief& belief, const PlaceView& view, ClassId own);

/// The class with the most views, that with the smaller id of two with equally many; `fallback` without views.
ClassId likeliestClass(const ClassBelief& belief, ClassId fallback);

/// Probability of each class under the belief; empty without views.
ClassWeights classProbabilities(const ClassBelief& belief);

/// Probability that there is a thing of class `label` at the place, n / (n + m / 3 + c + 2^g - 1), where n views found
/// it and m found something else. g views saw through it since: each is taken to double the odds that it is gone, which
/// before were one in n, since a thing found n times in a row is gone the next time with chance 1 / (n + 2). So a
/// thousand views are undone by ten that see through, two by two. c = 2 * 400 / (400 + points) is a prior of clutter,
/// which fades with the number of the thing's points. It is below 0.5 for a first sighting of few points, and where
/// fewer than one view in four finds the thing.
double existence(const ClassBelief& belief, ClassId label, double points);

}  // namespace hgg
