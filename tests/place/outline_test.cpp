#include "place/outline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.h"
#include "landmarks.h"

namespace hgg::outline_test {
namespace {

TEST(Outline, HoldsAllThingsAndIsConvex) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<Landmark> things = randomLandmarks(random, 30, 5);
    const auto& corners = outlineOf(things).corners;
    ASSERT_GE(corners.size(), 3U);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Eigen::Vector2d along = corners[(k + 1) % corners.size()] - corners[k];
      for (const Landmark& l : things) {
        const Eigen::Vector2d to = l.mean.head<2>() - corners[k];
        EXPECT_GE(along.x() * to.y() - along.y() * to.x(), -1e-12);
      }
    }
  }
}

TEST(Outline, OfASquareInClosedForm) {
  std::vector<Landmark> things;
  for (const double x : {0.0, 4.0}) {
    for (const double y : {0.0, 4.0}) {
      things.push_back(landmarkAt({x, y, 1}));
    }
  }
  things.push_back(landmarkAt({2, 4, 1}));  // on an edge
  const Outline outline = outlineOf(things);
  EXPECT_EQ(outline.corners.size(), 4U);
  EXPECT_NEAR(outline.room, 16 + 0.75 * 16 + kPi * 0.75 * 0.75, 1e-12);
  EXPECT_TRUE(isSurveyed(outline, {2, 2, 9}));
  EXPECT_TRUE(isSurveyed(outline, {0.3, 2, 0}));
  EXPECT_FALSE(isSurveyed(outline, {0.2, 2, 0}));
  EXPECT_FALSE(isSurveyed(outline, {5, 2, 0}));
}

TEST(Outline, OfFewThingsSurveysNothing) {
  const std::vector<Landmark> row{landmarkAt({0, 0, 0}), landmarkAt({1, 0, 0}), landmarkAt({3, 0, 0})};
  for (std::size_t n = 0; n <= row.size(); ++n) {
    const Outline outline = outlineOf(std::span(row).first(n));
    EXPECT_FALSE(isSurveyed(outline, {1, 0, 0}));
    EXPECT_TRUE(std::isfinite(outline.room));
  }
}

}  // namespace
}  // namespace hgg::outline_test
