#pragma once

#include <vector>

#include "map/class_evidence.h"

namespace hgg {

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
