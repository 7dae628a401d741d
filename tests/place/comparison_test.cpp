#include "place/comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "map/test_map.h"
#include "random_geometry.h"

namespace hgg::comparison_test {
namespace {

constexpr ClassId kCar = 10;

/// sqrt(0.08^2 + 0.3^2 s^2) with the mean horizontal variance s^2: closed form of what two drives may differ by.
TEST(Comparison, LandmarksAreAsUncertainAsAnotherDriveMakesThem) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    MapNode node = nodeAt(kCar, randomVector(random, 10));
    node.belief.cov = randomSpd(random, 1e-3);
    const Map map = mapOf({node});
    const Comparison c(map, map, {});
    ASSERT_EQ(c.a.landmarks.size(), 1U);
    const Mat3& cov = node.belief.cov;
    const double variance = 0.5 * (cov(0, 0) + cov(1, 1));
    EXPECT_NEAR(c.a.landmarks[0].sigma, std::sqrt(0.0064 + 0.09 * variance), 1e-12);
    EXPECT_EQ(c.a.landmarks[0].sigma, std::hypot(0.08, 0.3 * std::sqrt(variance)));
  }
}

TEST(Comparison, HasSurveyedNothingWithoutLeaves) {
  const Map map = mapOf({nodeAt(kCar, Vec3(1, 2, 0))});
  const Comparison c(map, map, {});
  EXPECT_EQ(c.survey_distance, 0);
  EXPECT_FALSE(c.index_a);
  EXPECT_FALSE(c.index_b);
}

}  // namespace
}  // namespace hgg::comparison_test
