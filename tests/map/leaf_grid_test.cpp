#include "map/leaf_grid.h"

#include <gtest/gtest.h>

#include "random_geometry.h"

namespace hgg::leaf_grid_test {
namespace {

TEST(FuseLeaves, KeepEvidenceAndMomentsInAnotherFrame) {
  std::mt19937 random(13);
  for (int round = 0; round < 30; ++round) {
    const Pose T = randomPose(random, 3);
    std::vector<Leaf> leaves;
    Belief expected;
    for (int view = 0; view < 4; ++view) {
      std::vector<Belief> additions;
      for (int k = 0; k < 50; ++k) {
        Belief b = randomBelief(random, 3);
        b.cov *= 0.01;
        additions.push_back(b);
        expected = merge(expected, transform(T, b));
      }
      leaves = fuseLeaves(leaves, additions, T, 0.4);
    }
    Belief merged;
    for (const Leaf& leaf : leaves) {
      merged = merge(merged, unpackLeaf(leaf));
    }
    EXPECT_EQ(merged.kappa, expected.kappa);
    EXPECT_LE((merged.mean - expected.mean).norm(), 1e-5);
    EXPECT_LE((merged.cov - expected.cov).norm(), 1e-4);
  }
}

TEST(FuseLeaves, FarApartStayApartAndOnTopOfEachOtherBecomeOne) {
  const Belief a{Vec3(0.2, 0.2, 0.2), 1e-4 * Mat3::Identity(), 5}, b{Vec3(0.2, 3.2, 0.2), 1e-4 * Mat3::Identity(), 7};
  std::vector<Leaf> leaves;
  leaves = fuseLeaves(leaves, std::vector<Belief>{a, b}, Pose::Identity(), 0.4);
  EXPECT_EQ(leaves.size(), 2U);
  for (int view = 0; view < 10; ++view) {
    leaves = fuseLeaves(leaves, std::vector<Belief>{b, a}, Pose::Identity(), 0.4);
  }
  ASSERT_EQ(leaves.size(), 2U);
  EXPECT_EQ(leaves[0].kappa + leaves[1].kappa, 11 * 12);
}

TEST(FuseLeaves, OfNothingChangeNothing) {
  std::vector<Leaf> leaves;
  leaves = fuseLeaves(leaves, {}, Pose::Identity(), 0.4);
  EXPECT_TRUE(leaves.empty());
}

}  // namespace
}  // namespace hgg::leaf_grid_test
