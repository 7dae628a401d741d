#include "alignment/structure.h"

#include <gtest/gtest.h>

#include <map>

#include "random_geometry.h"

namespace hgg::structure_test {
namespace {

TEST(NeighborHistograms, CountTheClassesAcrossEveryEdgeBothWays) {
  // A star: a car in the middle of two poles and another car.
  const std::vector<NeighborHistogram> h = neighborHistograms({10, 80, 80, 10}, {{0, 1}, {0, 2}, {0, 3}});
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

using Graph = std::vector<std::pair<int, int>>;

std::vector<Belief> randomLeaves(std::mt19937& random, int count) {
  std::vector<Belief> leaves;
  for (int k = 0; k < count; ++k) {
    leaves.push_back(randomBelief(random, 3));
  }
  return leaves;
}

TEST(WlFeatures, StartFromTheExtentAndTheDegree) {
  const Belief leaf{Vec3::Zero(), Vec3(1, 4, 9).asDiagonal(), 10};
  const Eigen::MatrixXd f = wlFeatures({leaf, leaf, leaf}, {{0, 1}, {1, 2}}, 0, 1e-9);
  ASSERT_EQ(f.cols(), 4);
  EXPECT_TRUE(f.row(1).isApprox(Eigen::RowVector4d(0, std::log(4), std::log(9), 2), 1e-9));
}

TEST(WlFeatures, ConcatenateTheMeanOverTheNeighbours) {
  std::mt19937 random(2);
  const std::vector<Belief> leaves = randomLeaves(random, 4);
  const Graph star{{0, 1}, {0, 2}};
  const Eigen::MatrixXd f0 = wlFeatures(leaves, star, 0, 0.01), f1 = wlFeatures(leaves, star, 1, 0.01);
  ASSERT_EQ(f1.cols(), 8);
  EXPECT_TRUE(f1.leftCols(4).isApprox(f0));
  EXPECT_TRUE(f1.row(0).tail(4).isApprox(0.5 * (f0.row(1) + f0.row(2))));
  EXPECT_TRUE(f1.row(1).tail(4).isApprox(f0.row(0)));
  EXPECT_EQ(f1.row(3).tail(4).norm(), 0);
  EXPECT_EQ(wlFeatures(leaves, star, 2, 0.01).cols(), 16);
  EXPECT_EQ(wlFeatures({}, {}, 2, 0.01).rows(), 0);
}

TEST(WlFeatures, DependNeitherOnThePoseNorOnTheNumbering) {
  std::mt19937 random(3);
  const std::vector<Belief> leaves = randomLeaves(random, 5);
  const Graph graph{{0, 1}, {1, 2}, {1, 3}, {3, 4}};
  const Pose T = randomPose(random, 10);
  std::vector<Belief> turned;
  for (int k = 4; k >= 0; --k) {
    turned.push_back(transform(T, leaves[static_cast<std::size_t>(k)]));
  }
  const Eigen::MatrixXd before = wlFeatures(leaves, graph, 2, 0.01);
  const Eigen::MatrixXd after = wlFeatures(turned, {{4, 3}, {3, 2}, {3, 1}, {1, 0}}, 2, 0.01);
  EXPECT_TRUE(after.colwise().reverse().isApprox(before, 1e-9));
}

TEST(HistogramDistance, ToNothingIsTheNorm) {
  EXPECT_EQ(histogramDistance({{10, 3}, {80, 4}}, {}), 5);
  EXPECT_EQ(histogramDistance({}, {}), 0);
}

}  // namespace
}  // namespace hgg::structure_test
