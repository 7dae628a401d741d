#include "creation/cluster.h"

#include <gtest/gtest.h>

#include <random>

#include "brute_force.h"
#include "kitti_frames.h"

namespace hgg::cluster_test {
namespace {

using Cloud = std::vector<PackedPoint>;

/// Blobs, sheets and lines at all ranges, so that gaps around r occur in every shell of range.
Cloud randomCloud(std::mt19937& random, int points, float extent) {
  std::uniform_real_distribution<float> anywhere(-extent, extent), size(0.02F, 3.0F), unit(-1, 1);
  Cloud cloud;
  while (static_cast<int>(cloud.size()) < points) {
    const PackedPoint centre(anywhere(random), anywhere(random), 0.1F * anywhere(random), 0);
    const PackedPoint half(size(random), size(random), size(random), 0);
    for (int k = std::uniform_int_distribution<int>(1, 60)(random); k > 0; --k) {
      cloud.push_back(centre + half * PackedPoint(unit(random), unit(random), unit(random), 0));
    }
  }
  return cloud;
}

TEST(ClusterEuclidean, EqualsBruteForceOnRandomClouds) {
  std::mt19937 random(1);
  const RadiusLaw laws[] = {{0.5F, 0}, {0.2F, 0.0157F}, {0.5F, 0.03F}, {0.05F, 0.1F}, {2.0F, 0.14F}, {0.02F, 0}};
  for (int round = 0; round < 12; ++round) {
    const Cloud cloud = randomCloud(random, 1500, round % 2 == 0 ? 8.0F : 60.0F);
    for (const RadiusLaw& law : laws) {
      EXPECT_EQ(clusterEuclidean(cloud, law), clusterByBruteForce(cloud, law))
          << "round " << round << ", r_min " << law.radius_min << ", slope " << law.slope;
    }
  }
}

TEST(ClusterEuclidean, EqualsBruteForceWhenPointsLieOnCellBorders) {
  // A lattice whose spacing is a cell, a radius or a hair beside them: every comparison is on the edge.
  const RadiusLaw law{0.5F, 0};
  for (const float spacing : {0.5F / 1.7320508F, 0.5F, 0.49999997F, 0.50000006F, 0.25F}) {
    Cloud cloud;
    for (int x = -4; x <= 4; ++x) {
      for (int y = -4; y <= 4; ++y) {
        cloud.emplace_back(static_cast<float>(x) * spacing, static_cast<float>(y) * spacing, 0.0F, 0.0F);
      }
    }
    EXPECT_EQ(clusterEuclidean(cloud, law), clusterByBruteForce(cloud, law)) << spacing;
  }
}

TEST(ClusterEuclidean, EqualsBruteForceAcrossTheShellsOfRange) {
  // A radial string whose gaps hover around r(d), so that almost every link crosses or grazes a shell border.
  std::mt19937 random(2);
  std::uniform_real_distribution<float> around(0.97F, 1.03F);
  for (int round = 0; round < 50; ++round) {
    const RadiusLaw law{0.1F, 0.05F};
    Cloud cloud;
    for (float d = 0.1F; d < 100;) {
      cloud.emplace_back(d, 0.0F, 0.0F, 0.0F);
      d += law.at(d) * around(random);
    }
    EXPECT_EQ(clusterEuclidean(cloud, law), clusterByBruteForce(cloud, law)) << "round " << round;
  }
}

TEST(ClusterEuclidean, NeighboursAreCloserThanTheRadiusNotAtIt) {
  const Cloud apart{{0, 0, 0, 0}, {0.5F, 0, 0, 0}}, close{{0, 0, 0, 0}, {0.499F, 0, 0, 0}};
  EXPECT_EQ(clusterEuclidean(apart, {0.5F, 0}), (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(clusterEuclidean(close, {0.5F, 0}), (std::vector<std::int32_t>{0, 0}));
}

TEST(ClusterEuclidean, RadiusGrowsWithTheRangeOfTheNearerPoint) {
  const RadiusLaw law{0.2F, 0.02F};
  const Cloud near{{5, 0, 0, 0}, {5.5F, 0, 0, 0}}, far{{50, 0, 0, 0}, {50.5F, 0, 0, 0}};
  EXPECT_EQ(clusterEuclidean(near, law).back(), 1);
  EXPECT_EQ(clusterEuclidean(far, law).back(), 0);
}

TEST(ClusterEuclidean, TakesNoPointsOnePointAndCopiesOfAPoint) {
  EXPECT_TRUE(clusterEuclidean({}, {0.5F, 0.01F}).empty());
  EXPECT_EQ(clusterEuclidean(Cloud{{0, 0, 0, 0}}, {0.5F, 0.01F}), (std::vector<std::int32_t>{0}));
  EXPECT_EQ(clusterEuclidean(Cloud(1000, PackedPoint(7, 8, 9, 0)), {0.02F, 0}), std::vector<std::int32_t>(1000, 0));
}

TEST(ClusterEuclidean, EqualsBruteForceOnTwentyRealFrames) {
  const auto folder = findKittiFrames(20);
  if (!folder) {
    GTEST_SKIP() << "skipped: no real data beside the repository (../shared/data)";
  }
  for (int frame = 0; frame < 20; ++frame) {
    Cloud cloud = readKittiPoints(*folder, frame);
    ASSERT_GT(cloud.size(), 90000U);
    // A crop that moves through the scene: 5000 consecutive points of a sector, plus a thinned far part.
    const std::size_t begin = static_cast<std::size_t>(frame) * 4000;
    const Cloud crop(cloud.begin() + static_cast<std::ptrdiff_t>(begin),
                     cloud.begin() + static_cast<std::ptrdiff_t>(begin + 5000));
    Cloud thinned;
    for (std::size_t i = static_cast<std::size_t>(frame); i < cloud.size() && thinned.size() < 5000;
         i += cloud.size() / 5000) {
      thinned.push_back(cloud[i]);
    }
    for (const RadiusLaw& law : {RadiusLaw{0.5F, 0.0157F}, RadiusLaw{0.2F, 0}}) {
      EXPECT_EQ(clusterEuclidean(crop, law), clusterByBruteForce(crop, law)) << "frame " << frame;
      EXPECT_EQ(clusterEuclidean(thinned, law), clusterByBruteForce(thinned, law)) << "frame " << frame;
    }
  }
}

}  // namespace
}  // namespace hgg::cluster_test
