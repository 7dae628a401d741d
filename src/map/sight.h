#pragma once

#include <cmath>
#include <vector>

#include "map/class_evidence.h"
#include "map/range_image.h"

namespace hgg {

/// The chance that a beam ended at a place, 0..1.
inline double takenBy(const BeamCount& beams) { return 1 - std::exp(-beams.ends); }
/// The chance that none ended there and one of those that passed would have hit what stood there, by the share of the
/// place's beams that were not hidden, 0..1.
inline double seenThroughBy(const BeamCount& beams) {
  const double all = beams.through + beams.hits + beams.hidden;
  return std::exp(-beams.ends) * (1 - std::exp(-beams.through)) * (all > 0 ? beams.through / all : 0);
}

/// Shares of the leaves of a thing, 0..1, that a look saw through, and that it found taken.
struct PlaceSight {
  double through = 0, taken = 0;
};

/// What a look sees at the place of leaves (map frame). As for class evidence a leaf is seen through by the chance that
/// one of the beams that pass would have hit it, and as far as none ended there. `variance` (m^2) and `variance_turn`
/// (rad^2) are of the pose that the leaves were seen from.
PlaceSight lookAt(const std::vector<Belief>& leaves, const FreeSpace& look, double variance, double variance_turn,
                  double sigma_floor);

}  // namespace hgg
