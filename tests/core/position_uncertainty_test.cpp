#include "core/position_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "random_geometry.h"

namespace hgg::position_uncertainty_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(PositionUncertainty, IsItsClosedForm) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const PositionModel m{uniform(random, 0, 1), uniform(random, 0, 0.1), uniform(random, 0, 1),
                          uniform(random, 0, 0.1)};
    const Mat3 cov = randomSpd(random, 1e-3);
    const double kappa = uniform(random, 1, 1000), views = uniform(random, 1, 50);
    const double extent = 1 / kappa + m.view_share * m.view_share / views + m.common_share * m.common_share;
    const double noise = m.view_noise * m.view_noise / views + m.common_noise * m.common_noise;
    EXPECT_LE((positionCovariance(m, cov, kappa, views) - extent * cov - noise * Mat3::Identity()).norm(), 1e-14);
  }
}

TEST(PositionUncertainty, WithinADriveHasTheFittedConstants) {
  const Mat3 cov = Vec3(4, 1, 0.25).asDiagonal();
  const Mat3 one = positionCovariance(kPositionWithinDrive, cov, 100, 1);
  const Mat3 expected = (0.01 + 0.49 + 0.0036) * cov + (0.0025 + 0.0004) * Mat3::Identity();
  EXPECT_LE((one - expected).norm(), 1e-14);
}

TEST(PositionUncertainty, OfAViewIsThatWithinTheDriveLessWhatAllViewsShare) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Mat3 cov = randomSpd(random, 1e-3);
    const double kappa = uniform(random, 1, 1000), views = uniform(random, 1, 50);
    const Mat3 shared = positionCovariance(kPositionWithinDrive, cov, kInfinity, kInfinity);
    const Mat3 whole = positionCovariance(kPositionWithinDrive, cov, kappa, views);
    EXPECT_LE((positionCovariance(kPositionOfView, cov, kappa, views) + shared - whole).norm(), 1e-14);
  }
}

TEST(PositionUncertainty, BetweenDrivesIsWhatManyPointsAndViewsLeave) {
  for (const double extent : {0.0, 0.1, 1.0, 20.0}) {
    const Mat3 cov =
        positionCovariance(kPositionBetweenDrives, extent * extent * Mat3::Identity(), kInfinity, kInfinity);
    const double sigma = commonDeviation(kPositionBetweenDrives, extent);
    EXPECT_NEAR(sigma * sigma, cov(0, 0), 1e-12 * (1 + cov(0, 0)));
  }
}

TEST(PositionUncertainty, BetweenDrivesIsLargerThanWithinOneOfManyViews) {
  const Mat3 cov = Vec3(4, 1, 0.25).asDiagonal();
  const Mat3 within = positionCovariance(kPositionWithinDrive, cov, kInfinity, 20);
  const Mat3 between = positionCovariance(kPositionBetweenDrives, cov, kInfinity, kInfinity);
  EXPECT_TRUE(((between - within).diagonal().array() > 0).all());
}

}  // namespace
}  // namespace hgg::position_uncertainty_test
