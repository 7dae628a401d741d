#pragma once

#include <span>
#include <vector>

#include "query/request.h"
#include "query/scene.h"
#include "query/views.h"

namespace hgg {

/// Likelihoods of what is said of a thing among its like, without anchors: one value for each of `things`, above 0, at
/// most 1. `is_peer` marks those that are as likely meant as any by what they are: first, last and largest are among
/// these.
struct Peers {
  std::span<const int> things;  // indices in the scene
  std::vector<bool> is_peer;
};

/// Of a value along which things are told apart: the largest is meant, or the rank-th largest.
std::vector<double> likelihoodOfRank(const std::vector<double>& values, const Peers& peers, const Constraint& said);
/// Of a place: on the left, in the middle, in the corner. `gazes`: how one may look.
std::vector<double> likelihoodOfPlace(const QueryScene& scene, const Peers& peers, const Constraint& said,
                                      const std::vector<Gaze>& gazes);
std::vector<double> likelihoodOfMeasure(const QueryScene& scene, const Peers& peers, const Constraint& said);
std::vector<double> likelihoodOfColour(const QueryScene& scene, const Peers& peers, const Constraint& said);

}  // namespace hgg
