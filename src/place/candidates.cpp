#include "place/candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/units.h"

namespace hgg {
namespace {

// All of these were chosen by hand. Tests hold what they are for (tests/place/candidates_test.cpp).
constexpr double kAreaMargin = 3;  // m, added to the sides of the bounding box: landmarks in a row cover ground too
constexpr double kSizeTolerance = 0.6;    // sizes differ by this share of the larger one at most
constexpr std::size_t kNeighbors = 3;     // of its own class, which tell a landmark from others like it
constexpr double kAlikeDistance = 0.3;    // m: distances to neighbours that differ by this or more are not alike at all
constexpr double kAlikeSize = 0.2;        // the same for sizes, as a share of the larger one
constexpr double kOtherClassPenalty = 1;  // a similar class is worth one neighbour that is not there
constexpr std::size_t kLabels = std::size_t{std::numeric_limits<ClassId>::max()} + 1;

/// The ground that landmarks spread over, m^2: their bounding box with a margin.
double areaOf(std::span<const Landmark> landmarks) {
  Eigen::AlignedBox2d box;
  for (const Landmark& l : landmarks) {
    box.extend(Eigen::Vector2d(l.mean.head<2>()));
  }
  return box.isEmpty() ? 1 : (box.sizes().array() + kAreaMargin).prod();
}

/// Number of landmarks of each label, by label.
std::vector<std::pair<ClassId, double>> countLabels(std::span<const Landmark> landmarks) {
  std::vector<std::pair<ClassId, double>> counts;
  for (const Landmark& l : landmarks) {
    const auto it = std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == l.label; });
    it == counts.end() ? void(counts.emplace_back(l.label, 1)) : void(++it->second);
  }
  return counts;
}

/// Finds the pairs of like class and size, one landmark of b at a time: there may be too many to hold them all.
class Pairing {
 public:
  Pairing(std::span<const Landmark> a, std::span<const Landmark> b, const Similarity& similarity);

  /// Landmarks of a that b's may be, ascending.
  void partnersOf(std::size_t j, std::vector<std::size_t>& partners);
  double weightOf(std::size_t i, std::size_t j) const { return std::log(oddsOf(i, j)); }

 private:
  /// How many times larger the ground is, for each rival on it, than the area within the pair's tolerance; times the
  /// similarity of the classes. A chance meeting is this unlikely.
  double oddsOf(std::size_t i, std::size_t j) const {
    return room_[a_[i].label] / (kPi * square(kToleranceSigmas) * varianceOfDifference(a_[i], b_[j]));
  }
  /// 2-Wasserstein distance of the extents with place and yaw taken out, against their size.
  bool isAlike(std::size_t i, std::size_t j) const {
    const double limit = std::max(kSizeTolerance * std::max(size_a_[i], size_b_[j]), a_[i].sigma + b_[j].sigma);
    return (a_[i].size - b_[j].size).squaredNorm() < square(limit);
  }

  std::span<const Landmark> a_, b_;
  const Similarity& similarity_;
  std::vector<std::pair<ClassId, double>> counts_;
  double area_;
  std::vector<double> size_a_, size_b_;
  std::vector<double> room_;  // m^2 for each rival of the landmark of b at hand, by label of a; 0 for none
};

Pairing::Pairing(std::span<const Landmark> a, std::span<const Landmark> b, const Similarity& similarity)
    : a_(a), b_(b), similarity_(similarity), counts_(countLabels(a)), area_(areaOf(a)), room_(kLabels, 0.0) {
  const auto sizeOf = [](const Landmark& l) { return l.size.norm(); };
  std::transform(a.begin(), a.end(), std::back_inserter(size_a_), sizeOf);
  std::transform(b.begin(), b.end(), std::back_inserter(size_b_), sizeOf);
}

void Pairing::partnersOf(std::size_t j, std::vector<std::size_t>& partners) {
  double rivals = 0;
  for (const auto& [label, count] : counts_) {
    rivals += similarity_(label, b_[j].label) > 0 ? count : 0;
  }
  for (const auto& [label, count] : counts_) {
    room_[label] = rivals > 0 ? area_ * similarity_(label, b_[j].label) / rivals : 0;
  }
  partners.clear();
  for (std::size_t i = 0; i < a_.size(); ++i) {
    if (oddsOf(i, j) > 1 && isAlike(i, j)) {
      partners.push_back(i);
    }
  }
}

/// How many partners each landmark may have, at least one, so that all together have `limit`. A landmark with fewer
/// leaves the rest of its share to the others.
std::size_t shareOf(std::vector<std::size_t> counts, std::size_t limit) {
  std::sort(counts.begin(), counts.end());
  std::size_t left = limit;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const std::size_t share = left / (counts.size() - k);
    if (counts[k] > share) {
      return std::max<std::size_t>(share, 1);
    }
    left -= counts[k];
  }
  return std::max<std::size_t>(limit, 1);
}

/// Horizontal distances to the nearest landmarks of the same label, ascending.
using Neighborhood = std::array<double, kNeighbors>;

std::vector<Neighborhood> neighborhoods(std::span<const Landmark> landmarks) {
  std::vector<Neighborhood> all;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    Neighborhood nearest;
    nearest.fill(std::numeric_limits<double>::max());
    for (std::size_t j = 0; j < landmarks.size(); ++j) {
      const double distance = (landmarks[i].mean - landmarks[j].mean).head<2>().squaredNorm();
      if (i != j && distance < nearest.back() && landmarks[i].label == landmarks[j].label) {
        nearest.back() = distance;
        std::inplace_merge(nearest.begin(), nearest.end() - 1, nearest.end());
      }
    }
    std::transform(nearest.begin(), nearest.end(), nearest.begin(), [](double d) { return std::sqrt(d); });
    all.push_back(nearest);
  }
  return all;
}

/// How little two landmarks of like class look like one: 0 .. 1 for their size, and as much for each of their
/// neighbours. A neighbour that only one map holds counts as not alike.
double unlikeness(const Landmark& a, const Landmark& b, const Neighborhood& around_a, const Neighborhood& around_b) {
  double sum = std::min(1.0, (a.size - b.size).norm() / (kAlikeSize * std::max(a.size.norm(), b.size.norm()) + 1e-9));
  for (std::size_t k = 0; k < kNeighbors; ++k) {
    sum += std::min(1.0, std::abs(around_a[k] - around_b[k]) / kAlikeDistance);
  }
  return sum;
}

template <typename Unlikeness>
void keepMostAlike(std::vector<std::size_t>& partners, std::size_t count, const Unlikeness& unlikenessOf) {
  std::vector<std::pair<double, std::size_t>> ranking;
  ranking.reserve(partners.size());
  for (const std::size_t i : partners) {
    ranking.emplace_back(unlikenessOf(i), i);
  }
  partners.resize(count);
  std::partial_sort(ranking.begin(), ranking.begin() + static_cast<std::ptrdiff_t>(count), ranking.end());
  std::transform(ranking.begin(), ranking.begin() + static_cast<std::ptrdiff_t>(count), partners.begin(),
                 [](const auto& ranked) { return ranked.second; });
  std::sort(partners.begin(), partners.end());
}

}  // namespace

std::vector<Match> candidateMatches(std::span<const Landmark> a, std::span<const Landmark> b,
                                    const Similarity& similarity, std::size_t limit) {
  Pairing pairing(a, b, similarity);
  std::vector<std::size_t> partners, counts;
  for (std::size_t j = 0; j < b.size(); ++j) {
    pairing.partnersOf(j, partners);
    counts.push_back(partners.size());
  }
  const std::size_t share = shareOf(counts, limit);
  const bool is_scarce = std::any_of(counts.begin(), counts.end(), [&](std::size_t n) { return n > share; });
  const std::vector<Neighborhood> around_a = is_scarce ? neighborhoods(a) : std::vector<Neighborhood>();
  const std::vector<Neighborhood> around_b = is_scarce ? neighborhoods(b) : std::vector<Neighborhood>();
  std::vector<Match> matches;
  for (std::size_t j = 0; j < b.size(); ++j) {
    pairing.partnersOf(j, partners);
    if (partners.size() > share) {
      keepMostAlike(partners, share, [&](std::size_t i) {
        return unlikeness(a[i], b[j], around_a[i], around_b[j]) + (a[i].label == b[j].label ? 0 : kOtherClassPenalty);
      });
    }
    for (const std::size_t i : partners) {
      matches.push_back({static_cast<int>(i), static_cast<int>(j), pairing.weightOf(i, j)});
    }
  }
  std::stable_sort(matches.begin(), matches.end(), [](const Match& p, const Match& q) { return p.weight > q.weight; });
  matches.resize(std::min(matches.size(), limit));
  return matches;
}

}  // namespace hgg
