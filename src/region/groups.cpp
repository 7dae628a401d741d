#include "region/groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/neighborhood.h"

namespace hgg {
namespace {

constexpr double kWider = 2;       // times the usual gap: then it separates
constexpr double kUnsure = 2;      // gaps: what is usual in a group of so few is known to its own size only
constexpr double kLeastGap = 1.0;  // m: what is closer is beside each other, however close

/// Groups that grow, with the gaps that were closed inside of each.
class GrowingGroups {
 public:
  explicit GrowingGroups(std::size_t things) : parent_(things), gaps_(things), closed_(things) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::size_t find(std::size_t k) {
    while (parent_[k] != k) {
      k = parent_[k] = parent_[parent_[k]];
    }
    return k;
  }
  bool mayTake(std::size_t group, double gap) const {
    const double n = closed_[group];
    return n == 0 || gap <= kWider * (1 + kUnsure / n) * gaps_[group] / n;
  }
  void join(std::size_t a, std::size_t b, double gap) {
    const auto [first, second] = std::minmax(a, b);
    parent_[second] = first;
    gaps_[first] += gaps_[second] + gap, closed_[first] += closed_[second] + 1;
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<double> gaps_, closed_;  // m, the sum of the gaps; how many
};

}  // namespace

double gapBetween(const Belief& a, const Belief& b) {
  const double kHalf = std::sqrt(3.0);  // of an edge, in standard deviations of what is spread evenly over it
  Vec3 way = b.mean - a.mean;
  way.z() = 0;
  const double distance = way.norm();
  if (distance < kLeastGap) {
    return kLeastGap;
  }
  way /= distance;
  const double taken = kHalf * (std::sqrt(way.dot(a.cov * way)) + std::sqrt(way.dot(b.cov * way)));
  return std::max(kLeastGap, distance - taken);
}

std::vector<std::vector<int>> groupInTheOpen(std::span<const Belief> things) {
  std::vector<Vec3> means;
  std::ranges::transform(things, std::back_inserter(means), [](const Belief& b) { return b.mean; });
  std::vector<std::tuple<double, double, std::size_t, std::size_t>> pairs;  // gap, distance, a, b
  for (const auto& [i, j] : relativeNeighborhood(means)) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    pairs.emplace_back(gapBetween(things[a], things[b]), (means[a] - means[b]).norm(), a, b);
  }
  std::ranges::sort(pairs);
  GrowingGroups groups(things.size());
  for (const auto& [gap, distance, i, j] : pairs) {
    const std::size_t a = groups.find(i), b = groups.find(j);
    if (a != b && groups.mayTake(a, gap) && groups.mayTake(b, gap)) {
      groups.join(a, b, gap);
    }
  }
  std::vector<std::vector<int>> found;
  std::vector<int> index(things.size(), -1);
  for (std::size_t k = 0; k < things.size(); ++k) {
    int& at = index[groups.find(k)];
    if (at < 0) {
      at = static_cast<int>(found.size());
      found.emplace_back();
    }
    found[static_cast<std::size_t>(at)].push_back(static_cast<int>(k));
  }
  return found;
}

}  // namespace hgg
