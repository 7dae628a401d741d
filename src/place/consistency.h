#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/types.h"

namespace hgg {

/// A thing as the search for a common place sees it: where it is, how surely, how large, and what.
struct Landmark {
  Vec3 mean = Vec3::Zero();
  double sigma = 0.1;        // m, standard deviation of the mean per axis: evidence, partial views, segmentation
  Vec3 size = Vec3::Zero();  // m, standard deviations of the extent: two horizontal ones, smaller first, and vertical
  ClassId label = 0;
};

/// Two landmarks that may be one thing, with what their meeting by chance would be surprised by (nats).
struct Match {
  int a = 0, b = 0;
  double weight = 0;
};

/// How alike two classes are, of a landmark of a and one of b: 1 the same, 0 never taken for each other.
using Similarity = std::function<double(ClassId label_a, ClassId label_b)>;

/// Pairs of like class and size. The weight is -ln of the chance that a random place holds such a landmark of a within
/// the pair's tolerance, so rare and sharply placed things count most; heaviest first. Where there are more than
/// `limit`, each landmark of b has the same number of partners at most, those most like it by size and by the distances
/// to its neighbours; landmarks of few partners keep all.
std::vector<Match> candidateMatches(std::span<const Landmark> a, std::span<const Landmark> b,
                                    const Similarity& similarity, std::size_t limit);

/// A place that some pairs agree on.
struct Hypothesis {
  Pose T_a_b = Pose::Identity();  // upright: yaw and translation
  std::vector<Match> clique;      // one-to-one, mutually consistent; ascending by a
  double weight = 0;              // of the clique, less half the squared residuals (nats)
};

/// The distinct places (more than 1 m or 5 degrees apart) with the heaviest cliques of the consistency graph, heaviest
/// first, at most `count`. A clique that shares one pair and one yaw is found by a sweep over the yaw, which leaves out
/// mirror images; the work is the square of the candidates.
std::vector<Hypothesis> findHypotheses(std::span<const Landmark> a, std::span<const Landmark> b,
                                       std::span<const Match> candidates, std::size_t count);

/// A point of a and the one of b it stands for.
struct PointPair {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double weight = 1;
};

/// The yaw and translation that minimise sum w |a - T b|^2, in closed form. Identity yaw where the points coincide.
Pose fitUpright(std::span<const PointPair> pairs);

/// Whether two transforms differ by more than 1 m (where it matters: at `centre_b`) or 5 degrees.
bool areDistinct(const Pose& T, const Pose& T_other, const Vec3& centre_b);

}  // namespace hgg
