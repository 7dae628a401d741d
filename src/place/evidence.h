#pragma once

#include <algorithm>
#include <vector>

#include "alignment/assignment.h"
#include "place/comparison.h"

namespace hgg {

/// What speaks for and against a transform between two maps, counted only where both maps have surveyed. Odds are log
/// likelihood ratios (nats): how much likelier the maps look so if the place is the same than if it is another.
struct PlaceEvidence {
  int things_matched = 0;    // pairs
  double things_missed = 0;  // things of either map whose place the other has surveyed without them, by share of leaves
  double thing_share = 0;    // share of the things that should be there and are, mean over the classes
  double thing_odds = 0;
  double surface_share =
      0;  // share of the surveyed upright leaves of stuff with a like surface of the other map on them
  double chance_share = 0;  // the same a few metres beside: what a wrong transform would get
  double surface_odds = 0;
  /// Share of its upright leaves (of its things, where there are no leaves) whose place the other map has surveyed, of
  /// the smaller map.
  double overlap = 0;

  /// Surfaces go on along a street or a corridor, so they never say more than the things do.
  double odds() const { return thing_odds + std::min(surface_odds, std::max(thing_odds, 0.0)); }
};

/// One-to-one pairs of like things (row in a, column in b) at a transform, within three standard deviations.
std::vector<Candidate> matchThings(const Comparison& c, const Pose& T_a_b);

/// Of the things that are left over, those of one place and size: one thing that two labellers call differently. Only a
/// whole graph's things are worth this; they are no evidence, as anything meets something.
std::vector<Candidate> matchOtherNames(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches);

/// Weighs a transform.
///   things:   a match adds ln(P(found) / chance of such a thing of a there) - d^2 / 2, a miss ln(1 - P(found)) times
///   the
///             share of its leaves that is missed; both are multiplied by the trust in the things
///   surfaces: half the nodes seen, times the Kullback-Leibler divergence of the share found from that found by chance
PlaceEvidence weighPlace(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches);

}  // namespace hgg
