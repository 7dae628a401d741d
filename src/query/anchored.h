#pragma once

#include <functional>
#include <vector>

#include "query/description.h"
#include "query/referent.h"
#include "query/request.h"
#include "query/scene.h"
#include "query/views.h"

namespace hgg {

/// Likelihoods of a relation for each of some things, summed over what its anchor may be. Values are above 0 and need
/// not add up.

/// In which directions from an anchor the relation is meant; not asked for relations that have none.
using DirectionsAt = std::function<std::vector<Gaze>(const SceneThing& anchor)>;

/// Of each of some things to one anchor, of all relations but between. Closest and farthest are of the peers.
std::vector<double> likelihoodsToOne(const QueryScene& scene, Relation relation, const Peers& peers,
                                     const SceneThing& anchor, const std::vector<Gaze>& directions);

/// Of all relations but far and between. What class the anchor is of counts as its word says, however well the things
/// of one class fit: each class's largest likelihood is its probability. So does which one of its class it is, where
/// `is_settled`: the words for it tell it from the others ("next to the tallest car").
std::vector<double> likelihoodsTo(const QueryScene& scene, Relation relation, const Peers& peers,
                                  const Referents& anchors, bool is_settled, const DirectionsAt& directions_at);
/// Far from all that the anchor may be.
std::vector<double> likelihoodsFarFrom(const QueryScene& scene, const Peers& peers, const Referents& anchors);
/// Between one of `a` and one of `b`; between two of `a` when `is_pair` is false.
std::vector<double> likelihoodsBetween(const QueryScene& scene, std::span<const int> things, const Referents& a,
                                       const Referents& b, bool is_pair);

}  // namespace hgg
