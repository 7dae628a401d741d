#include "alignment/pair_cost.h"

#include <gtest/gtest.h>

#include "core/spd.h"
#include "random_geometry.h"

namespace hgg::pair_cost_test {
namespace {

/// A box of these half sizes, evenly filled.
Belief box(const Vec3& mean, const Vec3& half) { return {mean, (half.cwiseAbs2() / 3).asDiagonal(), 100}; }

TEST(PairCost, IsTheWassersteinDistanceUnlessAnAblationSaysOtherwise) {
  std::mt19937 random(1);
  for (int k = 0; k < 20; ++k) {
    const Belief a = randomBelief(random, 5), b = randomBelief(random, 5);
    EXPECT_EQ(pairCost(a, b, PairCost::kWasserstein, 0.01, 3), wasserstein2(a, b));
    EXPECT_DOUBLE_EQ(pairCost(a, b, PairCost::kCentroid, 0.01, 3), (a.mean - b.mean).norm());
  }
}

TEST(PairCost, OfBoxesFallsWithTheShareTheyHaveInCommon) {
  const double apart = 3.3;
  const Belief a = box(Vec3(5, 0, 0), Vec3(2, 1, 1));
  const auto costOf = [&](const Belief& b) { return pairCost(a, b, PairCost::kIou, 1e-4, apart); };
  EXPECT_NEAR(costOf(a), 0, 1e-9);
  EXPECT_NEAR(costOf(box(Vec3(7, 0, 0), Vec3(2, 1, 1))), apart * (1 - 1.0 / 3), 1e-6);  // half of each
  EXPECT_NEAR(costOf(box(Vec3(5, 0, 0), Vec3(1, 1, 1))), apart * 0.5, 1e-6);            // one inside the other
  EXPECT_EQ(costOf(box(Vec3(9.1, 0, 0), Vec3(2, 1, 1))), apart);                        // nothing in common
}

}  // namespace
}  // namespace hgg::pair_cost_test
