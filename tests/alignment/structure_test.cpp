#include "alignment/structure.h"

#include <gtest/gtest.h>

#include <map>

#include "random_geometry.h"

namespace hgg {
namespace {

TEST(NeighborHistograms, CountTheClassesAcrossEveryEdgeBothWays) {
  // A star: a car in the middle of two poles and another car.
  const std::vector<NeighborHistogram> h =
      neighborHistograms({10, 80, 80, 10}, {{0, 1, 0.5}, {0, 2, 0.5}, {0, 3, 0.5}});
  ASSERT_EQ(h.size(), 4U);
  EXPECT_EQ(h[0], (NeighborHistogram{{10, 1}, {80, 2}}));
  EXPECT_EQ(h[1], (NeighborHistogram{{10, 1}}));
  EXPECT_EQ(h[3], (NeighborHistogram{{10, 1}}));
}

TEST(NeighborHistograms, OfNodesWithoutEdgesAreEmpty) {
  const std::vector<NeighborHistogram> h = neighborHistograms({10, 80}, {});
  EXPECT_EQ(h, std::vector<NeighborHistogram>(2));
  EXPECT_TRUE(neighborHistograms({}, {}).empty());
}

TEST(HistogramDistance, EqualsTheNormOverAllClasses) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    std::map<ClassId, int> counts_a, counts_b;
    for (int k = 0; k < 6; ++k) {
      counts_a[static_cast<ClassId>(below(random, 8))] = 1 + static_cast<int>(below(random, 4));
      counts_b[static_cast<ClassId>(below(random, 8))] = 1 + static_cast<int>(below(random, 4));
    }
    double square = 0;
    for (ClassId c = 0; c < 8; ++c) {
      const int difference = (counts_a.contains(c) ? counts_a[c] : 0) - (counts_b.contains(c) ? counts_b[c] : 0);
      square += difference * difference;
    }
    const NeighborHistogram a(counts_a.begin(), counts_a.end()), b(counts_b.begin(), counts_b.end());
    EXPECT_DOUBLE_EQ(histogramDistance(a, b), std::sqrt(square));
    EXPECT_DOUBLE_EQ(histogramDistance(b, a), std::sqrt(square));
    EXPECT_EQ(histogramDistance(a, a), 0);
  }
}

TEST(HistogramDistance, ToNothingIsTheNorm) {
  EXPECT_EQ(histogramDistance({{10, 3}, {80, 4}}, {}), 5);
  EXPECT_EQ(histogramDistance({}, {}), 0);
}

}  // namespace
}  // namespace hgg
