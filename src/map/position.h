#pragma once

#include "map/map.h"

namespace hgg {

/// How well positions are known, m^2, map axes. There are three questions, and positionCovariance(node) (map/node.h)
/// answers the first: how well the mean is known relative to the keyframe it is anchored to.

/// Where in the map: the frame of the first keyframe. That of the first question, and how far the anchor keyframe may
/// have drifted from the first keyframe on the way to there, its turn swinging the mean about it.
Mat3 positionCovarianceInMap(const Map& map, const MapNode& node);

/// Where relative to each other: of the difference of the two means. What both have drifted alike does not count, but
/// for the turn of their neighbourhood in the map, which turns the difference. Searches the keyframes between the two
/// anchors: microseconds for neighbours, milliseconds for the ends of a long drive.
Mat3 relativeCovariance(const Map& map, const MapNode& a, const MapNode& b);

/// The same for many nodes b beside one anchor: `from_anchor` is covariancesFrom(map.keyframes(), a.anchor).
Mat3 relativeCovariance(const Map& map, const MapNode& a, const MapNode& b, const std::vector<Mat6>& from_anchor);

}  // namespace hgg
