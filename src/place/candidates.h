#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/types.h"
#include "core/units.h"

namespace hgg {

/// A thing of a map as the search for a common place sees it: where it is, how surely, how large, and what.
struct Landmark {
  Vec3 mean = Vec3::Zero();
  double sigma = 0.1;        // m, standard deviation of the mean per axis, against another drive's map
  Vec3 size = Vec3::Zero();  // m, standard deviations of the extent: two horizontal ones, smaller first, and vertical
  ClassId label = 0;
};

/// Two landmarks that may be the same thing. The weight is -ln of the probability that they meet by chance (nats).
struct Match {
  int a = 0, b = 0;
  double weight = 0;
};

/// How alike two classes are, of a landmark of a and one of b: 1 the same, 0 never taken for each other.
using Similarity = std::function<double(ClassId label_a, ClassId label_b)>;

/// Landmarks that lie farther apart than this many standard deviations of their difference are not the same thing. Of
/// true pairs 98.8 % lie within along an axis and 95.6 % in the plane (normal and Rayleigh distribution). Chosen by
/// hand.
inline constexpr double kToleranceSigmas = 2.5;

/// Variance of the difference of two landmarks' means along an axis, m^2.
inline double varianceOfDifference(const Landmark& a, const Landmark& b) { return square(a.sigma) + square(b.sigma); }

/// Pairs of like class and size, heaviest first. The weight is -ln of the chance that a random place holds such a
/// landmark of a within the pair's tolerance, so rare and sharply placed things count most. Where there are more than
/// `limit` pairs, each landmark of b keeps the same number of partners at most, those most like it by size and by the
/// distances to its neighbours; landmarks with few partners keep all.
std::vector<Match> candidateMatches(std::span<const Landmark> a, std::span<const Landmark> b,
                                    const Similarity& similarity, std::size_t limit);

}  // namespace hgg
