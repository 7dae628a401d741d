#pragma once

#include <span>

#include "eval/objects.h"
#include "map/map.h"

namespace hgg {

/// Pairs of things are neighbours up to this distance, m.
inline constexpr double kNeighbourReach = 30;

/// Whether the map keeps its word on how found objects lie to each other: differences of two positions against the
/// true ones, under relativeCovariance (map/position.h), of all pairs whose true positions are within `reach` (m).
/// `R_truth_map` turns differences of the map's frame into the truth's. Matches name nodes of `map`; others are left
/// out.
Calibration relativeCalibration(const Map& map, const std::vector<ObjectMatch>& matches,
                                std::span<const TruthObject> truth, const Mat3& R_truth_map, double reach);

}  // namespace hgg
