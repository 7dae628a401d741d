#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "eval/calibration.h"
#include "sim/random.h"

namespace hgg::calibration_eval_test {
namespace {

TEST(ChiSquareCdf, MeetsTabulatedQuantiles) {
  EXPECT_NEAR(chiSquareCdf(kChiSquare90), 0.9, 1e-4);
  EXPECT_NEAR(chiSquareCdf(2.366), 0.5, 1e-4);
  EXPECT_NEAR(chiSquareCdf(7.815), 0.95, 1e-4);
  EXPECT_EQ(chiSquareCdf(0), 0.0);
  EXPECT_EQ(chiSquareCdf(-1), 0.0);
}

TEST(NormalisedSquare, EqualsItsArithmetic) {
  const Mat3 cov = Vec3(4, 1, 0.25).asDiagonal();
  EXPECT_NEAR(normalisedSquare(Vec3(2, 0, 0), cov), 1.0, 1e-12);
  EXPECT_NEAR(normalisedSquare(Vec3(2, 3, 1), cov), 1.0 + 9.0 + 4.0, 1e-12);
  Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(normalisedSquare(R * Vec3(2, 3, 1), R * cov * R.transpose()), 14.0, 1e-9);
}

TEST(NormalisedSquare, FlatCovarianceStaysFinite) {
  EXPECT_NEAR(normalisedSquare(Vec3(0, 0, 1e-3), Vec3(1, 1, 0).asDiagonal()), 100.0, 1e-6);
  EXPECT_EQ(normalisedSquare(Vec3::Zero(), Mat3::Zero()), 0.0);
}

/// Errors drawn from a covariance, judged under that covariance divided by `boast` squared.
std::vector<double> drawn(std::size_t n, double boast) {
  Mat3 L;
  L << 0.3, 0, 0, 0.1, 0.2, 0, -0.05, 0.02, 0.05;
  std::vector<double> squares;
  for (std::uint64_t i = 0; i < n; ++i) {
    const RandomKey key{42, i};
    const Vec3 error = L * Vec3(gaussian(key, 0), gaussian(key, 1), gaussian(key, 2));
    squares.push_back(normalisedSquare(error, L * L.transpose() / (boast * boast)));
  }
  return squares;
}

TEST(Calibrate, HonestDrawsAreCalibratedWithinChance) {
  const std::size_t n = 4000;
  const Calibration c = calibrate(drawn(n, 1.0), {});
  EXPECT_EQ(c.count, n);
  // The sum of n chi-squares with 3 degrees has mean 3n and variance 6n: four deviations.
  EXPECT_NEAR(c.mean_over_3, 1.0, 4 * std::sqrt(6.0 / n) / 3);
  EXPECT_NEAR(c.median_over_3, 2.366 / 3, 0.05);
  EXPECT_NEAR(c.inside_90, 0.9, 4 * std::sqrt(0.9 * 0.1 / n));
  for (std::size_t k = 0; k < c.inside.size(); ++k) {
    const double p = 0.05 * static_cast<double>(k + 1);
    EXPECT_NEAR(c.inside[k], p, 4 * std::sqrt(p * (1 - p) / n)) << p;
  }
}

TEST(Calibrate, BoastfulDrawsAreFoundOut) {
  const Calibration c = calibrate(drawn(4000, 3.0), {});
  EXPECT_NEAR(c.mean_over_3, 9.0, 0.5);
  EXPECT_NEAR(c.inside_90, chiSquareCdf(kChiSquare90 / 9), 0.03);
}

TEST(Calibrate, CountsTheEdgeInside) {
  const Calibration c = calibrate(std::vector<double>{3.0, kChiSquare90, 6.3, 12.0}, {});
  EXPECT_DOUBLE_EQ(c.inside_90, 0.5);
  EXPECT_DOUBLE_EQ(c.mean_over_3, (3.0 + 6.251 + 6.3 + 12.0) / 12);
}

TEST(Calibrate, SharpnessIsTheRootMeanSquareDeviation) {
  EXPECT_DOUBLE_EQ(calibrate(std::vector<double>{1.0, 1.0}, std::vector<double>{0.01, 0.17}).mean_sigma, 0.3);
}

TEST(Calibrate, NothingHasNoCalibration) {
  const Calibration c = calibrate({}, {});
  EXPECT_TRUE(std::isnan(c.mean_over_3));
  EXPECT_TRUE(std::isnan(c.inside_90));
  EXPECT_TRUE(std::isnan(c.inside[0]));
  EXPECT_TRUE(std::isnan(c.mean_sigma));
}

}  // namespace
}  // namespace hgg::calibration_eval_test
