#include "place/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "random_geometry.h"

namespace hgg::surfaces_test {
namespace {

std::vector<Surface> randomSurfaces(std::mt19937& random, std::size_t n) {
  std::vector<Surface> surfaces(n);
  for (Surface& s : surfaces) {
    s.mean = randomVector(random, 5);
    s.mean.z() *= 0.1;
  }
  return surfaces;
}

TEST(SurfaceIndex, FindsWhatBruteForceFinds) {
  std::mt19937 random(1);
  for (const std::size_t n : {0, 1, 2, 40, 3000}) {
    std::vector<Surface> surfaces = randomSurfaces(random, n);
    if (n > 2) {
      surfaces[1].mean = surfaces[0].mean;  // coincident leaves are both found
    }
    const SurfaceIndex index(surfaces);
    std::vector<std::size_t> found{7};
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 p = trial < 3 && n > 2 ? surfaces[static_cast<std::size_t>(trial)].mean : randomVector(random, 6);
      const double radius = uniform(random, 0.01, 2);
      std::vector<std::size_t> expected;
      for (std::size_t i = 0; i < n; ++i) {
        if ((surfaces[i].mean - p).norm() < radius) {
          expected.push_back(i);
        }
      }
      index.near(p, radius, found);
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected) << n << " surfaces, trial " << trial;
    }
  }
}

TEST(SurfaceIndex, AnswersInTheSameOrderWhenBuiltAgain) {
  std::mt19937 random(2);
  const std::vector<Surface> surfaces = randomSurfaces(random, 1000);
  const SurfaceIndex first(surfaces), second(surfaces);
  std::vector<std::size_t> found, again;
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 p = randomVector(random, 5);
    first.near(p, 1, found);
    second.near(p, 1, again);
    EXPECT_EQ(found, again);
  }
}

TEST(SurfaceIndex, BearsAnyRadiusAndAnyPoint) {
  const double infinite = std::numeric_limits<double>::infinity();
  std::vector<Surface> surfaces(4);
  surfaces[1].mean = Vec3::Constant(1e300);
  surfaces[2].mean = Vec3::Constant(std::nan(""));
  surfaces[3].mean = Vec3(infinite, 0, 0);
  const SurfaceIndex index(surfaces);
  for (const double radius : {0.0, -1.0, std::nan(""), 1e-300, 0.5}) {
    for (const double x : {0.0, -1e300, infinite, std::nan("")}) {
      std::vector<std::size_t> found{7};
      index.near(Vec3::Constant(x), radius, found);
      EXPECT_EQ(found.size(), radius == 0.5 && x == 0 ? 1U : 0U) << radius << ", " << x;
    }
  }
}

}  // namespace
}  // namespace hgg::surfaces_test
