#pragma once

#include <span>
#include <vector>

#include "alignment/pose_search.h"
#include "core/types.h"
#include "core/units.h"
#include "place/candidates.h"

namespace hgg {

/// A transform between the maps that some pairs agree on.
struct Hypothesis {
  Pose T_a_b = Pose::Identity();  // upright: yaw and translation
  std::vector<Match> clique;      // one-to-one, mutually consistent; ascending by a
  double weight = 0;              // nats: summed over the clique, less half the squared residuals
};

/// The places with the heaviest cliques of the consistency graph, heaviest first, at most `count` and all distinct. A
/// clique is found around one of its pairs: every consistent pair admits an interval of yaw, and a sweep over the yaw
/// finds the heaviest set that shares one, which rules out mirror images. Cost grows with the square of the candidates.
std::vector<Hypothesis> findHypotheses(std::span<const Landmark> a, std::span<const Landmark> b,
                                       std::span<const Match> candidates, std::size_t count);

/// A point of a and the point of b that is the same.
struct PointPair {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double weight = 1;
};

/// The yaw and translation that minimise sum w |a - T b|^2, in closed form. Identity yaw where the points coincide.
Pose fitUpright(std::span<const PointPair> pairs);

/// Whether two transforms differ by more than kDistinctDistance at `centre_b` or by more than kDistinctTurn.
bool areDistinct(const Pose& T, const Pose& T_other, const Vec3& centre_b);

}  // namespace hgg
