#include "alignment/pair_cost.h"

#include <gtest/gtest.h>

#include "core/spd.h"
#include "random_geometry.h"

namespace hgg {
namespace {

Config costing(PairCost cost) {
  Config config;
  config.ablation.cost = cost;
  return config;
}

/// A box of these half sizes, evenly filled.
Belief box(const Vec3& mean, const Vec3& half) { return {mean, (half.cwiseAbs2() / 3).asDiagonal(), 100}; }

TEST(PairCost, IsTheWassersteinDistanceUnlessAnAblationSaysOtherwise) {
  std::mt19937 random(1);
  for (int k = 0; k < 20; ++k) {
    const Belief a = randomBelief(random, 5), b = randomBelief(random, 5);
    EXPECT_EQ(pairCost(a, b, Config{}), wasserstein2(a, b));
    EXPECT_DOUBLE_EQ(pairCost(a, b, costing(PairCost::kCentroid)), (a.mean - b.mean).norm());
  }
}

TEST(PairCost, OfBoxesFallsWithTheShareTheyHaveInCommon) {
  Config config = costing(PairCost::kIou);
  config.creation.sigma_floor = 1e-4;
  const double far = config.alignment.gate / config.alignment.geometry_share;
  const Belief a = box(Vec3(5, 0, 0), Vec3(2, 1, 1));
  EXPECT_NEAR(pairCost(a, a, config), 0, 1e-9);
  EXPECT_NEAR(pairCost(a, box(Vec3(7, 0, 0), Vec3(2, 1, 1)), config), far * (1 - 1.0 / 3), 1e-6);  // half of each
  EXPECT_NEAR(pairCost(a, box(Vec3(5, 0, 0), Vec3(1, 1, 1)), config), far * 0.5, 1e-6);            // one inside
  EXPECT_EQ(pairCost(a, box(Vec3(9.1, 0, 0), Vec3(2, 1, 1)), config), far);  // apart: never below the gate
}

}  // namespace
}  // namespace hgg
