#pragma once

#include <cstdint>
#include <vector>

#include "alignment/correspondence.h"
#include "alignment/registration.h"

namespace hgg {

/// How a pose came about: by leaves of the map in every direction, in some directions only, or by odometry alone.
enum class PoseSource : std::uint8_t { kAligned, kDegenerate, kOdometry };

/// The word for it in messages and logs: "aligned", "degenerate" or "odometry".
const char* nameOf(PoseSource source);

/// What alignment found, with its evidence.
struct Alignment {
  PoseBelief pose;  // T_fine; its information is that of the prior and of the pairs where they were heard
  std::vector<ObjectPair> pairs;
  std::size_t leaf_pairs = 0;
  /// Unit directions of the pose's tangent in which the map says less than odometry does; there it is odometry's.
  std::vector<Vec6> degenerate_directions;
  PoseSource source = PoseSource::kOdometry;
};

/// Coarse-to-fine alignment of a frame's graph with the map: correspondence and registration over objects and their
/// edges, then over the leaves of matched objects. `prior` is what odometry predicts.
Alignment align(const LocalGraph& local, const Map& map, const PoseBelief& prior, const Config& config);

/// The covariance a leaf is matched under, of its own: where on its surface a leaf has its mean is chance, so the
/// flatter it is the less it says along its surface. lambda_k^3 / lambda_min^2 keeps the thickness of a plane and the
/// extent of a ball.
Mat3 regularized(const Mat3& cov);

}  // namespace hgg
