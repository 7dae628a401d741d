#pragma once

#include <algorithm>
#include <vector>

#include "alignment/assignment.h"
#include "place/comparison.h"

namespace hgg {

/// What speaks for and against a transform between two maps, where both have surveyed. Odds are logarithms (nats) of
/// how much likelier it is if the place is the same than if it is another.
struct PlaceEvidence {
  int things_matched = 0;    // pairs
  double things_missed = 0;  // things of either map that the other has surveyed and lacks, by their share of leaves
  double thing_share = 0;    // of what should be there, what is: mean over the classes of things
  double thing_odds = 0;
  double surface_share =
      0;  // upright leaves of stuff, of what the other has surveyed, with a like surface of it on them
  double chance_share = 0;  // the same a few metres beside: what a wrong transform would get
  double surface_odds = 0;
  double overlap = 0;  // share of its upright leaves of stuff that the other has surveyed, of the smaller map

  /// Surfaces go on along a street or a corridor: they do not say more than the things.
  double odds() const { return thing_odds + std::min(surface_odds, std::max(thing_odds, 0.0)); }
};

/// One-to-one pairs of like things (row in a, column in b) at a transform, within three standard deviations.
std::vector<Candidate> matchThings(const Comparison& c, const Pose& T_a_b);

/// Weighs a transform.
///   things:   a match ln(found / chance of such a thing of a there) - d^2 / 2; a miss, by its share, ln(1 - found);
///             both times how far the things are to be trusted
///   surfaces: half the nodes seen, times the divergence of the share found from that found by chance
PlaceEvidence weighPlace(const Comparison& c, const Pose& T_a_b, const std::vector<Candidate>& matches);

}  // namespace hgg
