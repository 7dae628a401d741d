#pragma once

#include <cstdint>
#include <vector>

#include "alignment/correspondence.h"
#include "alignment/fit.h"
#include "alignment/registration.h"

namespace hgg {

/// How a pose came about: the map's leaves determined it in every direction, in some directions only, or not at all, so
/// that it is odometry's.
enum class PoseSource : std::uint8_t { kAligned, kDegenerate, kOdometry };

/// Its name in messages and logs: "aligned", "degenerate" or "odometry".
const char* nameOf(PoseSource source);

/// The pose that alignment found, and what it rests on.
struct Alignment {
  PoseBelief pose;  // T_fine; its information is the prior's plus that of the pairs, but in degenerate directions
  std::vector<ObjectPair> pairs;
  std::size_t leaf_pairs = 0;
  Fit fit;
  /// Unit directions of the pose's tangent in which the map knows less than odometry; there the pose is odometry's.
  std::vector<Vec6> degenerate_directions;
  PoseSource source = PoseSource::kOdometry;
};

/// Coarse-to-fine alignment of a frame's graph with the map: correspondence and registration over objects and their
/// edges, then over the leaves of matched objects. `prior` is what odometry predicts.
Alignment align(const LocalGraph& local, const Map& map, const PoseBelief& prior, const Config& config);

/// The covariance of a leaf of covariance `cov` when it is matched by itself (m^2). Where on its surface a leaf has its
/// mean is chance, so the flatter a leaf is, the less it says along its surface: each variance lambda_k becomes
/// lambda_k^3 / lambda_min^2, which keeps the thickness of a plane and the extent of a ball.
Mat3 regularized(const Mat3& cov);

}  // namespace hgg
