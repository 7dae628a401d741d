#include "core/belief.h"

#include <gtest/gtest.h>

#include "random_geometry.h"

namespace hgg::belief_test {
namespace {

void expectSame(const Belief& actual, const Belief& expected, double tolerance) {
  EXPECT_LE((actual.mean - expected.mean).norm(), tolerance);
  EXPECT_LE((actual.cov - expected.cov).norm(), tolerance);
  EXPECT_EQ(actual.kappa, expected.kappa);
}

/// Mean and population covariance in extended precision, straight from the definition.
Belief byDefinition(const std::vector<Vec3>& points) {
  using WideVec = Eigen::Matrix<long double, 3, 1>;
  const auto n = static_cast<long double>(points.size());
  WideVec mean = WideVec::Zero();
  for (const Vec3& p : points) {
    mean += p.cast<long double>() / n;
  }
  Eigen::Matrix<long double, 3, 3> cov = Eigen::Matrix<long double, 3, 3>::Zero();
  for (const Vec3& p : points) {
    const WideVec d = p.cast<long double>() - mean;
    cov += d * d.transpose() / n;
  }
  return {mean.cast<double>(), cov.cast<double>(), static_cast<double>(points.size())};
}

std::vector<Vec3> pooled(std::initializer_list<std::vector<Vec3>> sets) {
  std::vector<Vec3> all;
  for (const std::vector<Vec3>& set : sets) {
    all.insert(all.end(), set.begin(), set.end());
  }
  return all;
}

TEST(BeliefFromPoints, IsTheSampleMeanAndThePopulationCovariance) {
  std::mt19937 random(1);
  for (const int n : {2, 3, 10, 500}) {
    const std::vector<Vec3> points = randomPoints(random, n, Vec3(5, -3, 1));
    expectSame(beliefFromPoints(points), byDefinition(points), 1e-12);
  }
}

TEST(BeliefFromPoints, OfNoPointsIsEmptyAndOfOneIsThatPoint) {
  expectSame(beliefFromPoints({}), Belief{}, 0);
  const std::vector<Vec3> one{Vec3(1, 2, 3)}, copies(7, Vec3(1, 2, 3));
  expectSame(beliefFromPoints(one), {Vec3(1, 2, 3), Mat3::Zero(), 1}, 0);
  expectSame(beliefFromPoints(copies), {Vec3(1, 2, 3), Mat3::Zero(), 7}, 1e-15);
}

TEST(BeliefFromPoints, KeepsTheCovarianceFarFromTheOrigin) {
  std::mt19937 random(2);
  const Vec3 far(1e5, -1e5, 1e3);
  const std::vector<Vec3> points = randomPoints(random, 1000, far);
  const Belief expected = byDefinition(points);
  const Belief actual = beliefFromPoints(points);
  EXPECT_LE(relativeError(actual.cov, expected.cov), 1e-12);
  EXPECT_LE((actual.mean - expected.mean).norm(), 1e-9);
}

TEST(Moments, ShiftedByAnyPointOfTheSetGiveTheSameBeliefFarFromTheOrigin) {
  std::mt19937 random(3);
  const std::vector<Vec3> points = randomPoints(random, 400, Vec3(1e5, 1e5, 50));
  Moments moments(points.front());
  for (const Vec3& p : points) {
    moments.add(p.x(), p.y(), p.z());
  }
  EXPECT_EQ(moments.count(), 400);
  EXPECT_LE(relativeError(moments.belief().cov, byDefinition(points).cov), 1e-12);
}

TEST(Moments, NeverGiveANegativeVariance) {
  std::mt19937 random(4);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 origin = randomVector(random, 10), p = randomVector(random, 10);
    Moments moments(origin);
    for (int i = 0; i < 3; ++i) {
      moments.add(p.x(), p.y(), p.z());
    }
    EXPECT_GE(moments.belief().cov.diagonal().minCoeff(), 0);
  }
}

TEST(Merge, EqualsPoolingTheRawPoints) {
  std::mt19937 random(5);
  for (int k = 0; k < 50; ++k) {
    const std::vector<Vec3> a = randomPoints(random, 1 + k, randomVector(random, 3));
    const std::vector<Vec3> b = randomPoints(random, 1 + 7 * k, randomVector(random, 3));
    expectSame(merge(beliefFromPoints(a), beliefFromPoints(b)), byDefinition(pooled({a, b})), 1e-12);
  }
}

TEST(Merge, OfManyFragmentsInAnyOrderIsTheSame) {
  std::mt19937 random(6);
  for (int k = 0; k < 50; ++k) {
    const Belief a = randomBelief(random, 5), b = randomBelief(random, 5), c = randomBelief(random, 5);
    expectSame(merge(merge(a, b), c), merge(a, merge(b, c)), 1e-12);
    expectSame(merge(a, b), merge(b, a), 1e-13);
  }
}

TEST(Merge, WithNothingChangesNothing) {
  std::mt19937 random(7);
  const Belief a = randomBelief(random, 5);
  expectSame(merge(a, Belief{}), a, 0);
  expectSame(merge(Belief{}, a), a, 0);
  expectSame(merge(Belief{}, Belief{}), Belief{}, 0);
}

TEST(Merge, OfAThousandFragmentsFarAwayKeepsTheCovariance) {
  std::mt19937 random(8);
  const Vec3 far(1e5, 2e5, -10);
  std::vector<Vec3> all;
  Belief sum;
  for (int k = 0; k < 1000; ++k) {
    const std::vector<Vec3> part = randomPoints(random, 5, far);
    sum = merge(sum, beliefFromPoints(part));
    all.insert(all.end(), part.begin(), part.end());
  }
  const Belief expected = byDefinition(all);
  EXPECT_LE(relativeError(sum.cov, expected.cov), 1e-9);
  EXPECT_EQ(sum.kappa, 5000);
}

TEST(Transform, OfABeliefEqualsTheBeliefOfTransformedPoints) {
  std::mt19937 random(9);
  for (int k = 0; k < 50; ++k) {
    const Pose T = randomPose(random, 50);
    const std::vector<Vec3> points = randomPoints(random, 40, randomVector(random, 20));
    std::vector<Vec3> moved;
    for (const Vec3& p : points) {
      moved.emplace_back(T * p);
    }
    expectSame(transform(T, beliefFromPoints(points)), byDefinition(moved), 1e-11);
    expectSame(transform(T.inverse(), transform(T, beliefFromPoints(points))), beliefFromPoints(points), 1e-11);
  }
}

TEST(CovarianceOfIndependentPoints, ShrinksWithTheEvidence) {
  Belief b{Vec3::Zero(), Vec3(4, 2, 1).asDiagonal(), 100};
  EXPECT_TRUE(covarianceOfIndependentPoints(b).isApprox(b.cov / 100, 1e-15));
  b.kappa = 0;
  EXPECT_TRUE(covarianceOfIndependentPoints(b).allFinite());
}

TEST(EdgeDistance, IsTheSumOfItsTwoPartsOverTheFloor) {
  // Both covariances are s^2 I once floored, so the affine part is sqrt(3) |ln(4)| and the other is |d| over the mean
  // variance.
  const double floor = 0.1;
  const Belief a{Vec3(0, 0, 0), Mat3::Identity() * (0.04 - floor * floor), 5};
  const Belief b{Vec3(1, 2, 2), Mat3::Identity() * (0.16 - floor * floor), 7};
  EXPECT_NEAR(edgeDistance(a, b, floor), 3 / std::sqrt(0.1) + std::sqrt(3.0) * std::log(4.0), 1e-12);
}

TEST(EdgeDistance, IsFiniteOnPointAndLineExtents) {
  const Vec3 v(1, 2, 3);
  const Belief point{Vec3(0, 0, 0), Mat3::Zero(), 1}, line{Vec3(1, 0, 0), v * v.transpose(), 2};
  EXPECT_TRUE(std::isfinite(edgeDistance(point, line, 0.01)));
  EXPECT_GT(edgeDistance(point, line, 0.01), 0);
  EXPECT_NEAR(edgeDistance(point, point, 0.01), 0, 1e-9);
}

TEST(BhattacharyyaCoefficient, IsOneOnItselfAndFollowsTheClosedFormApart) {
  const Belief a{Vec3(0, 0, 0), Mat3::Identity(), 1}, b{Vec3(2, 0, 0), Mat3::Identity() * 4, 1};
  EXPECT_NEAR(bhattacharyyaCoefficient(a, a, 0), 1, 1e-12);
  const double expected = std::exp(-4.0 / 2.5 / 8) * std::pow(2.0 / 2.5, 1.5);  // (sigma_a sigma_b / s^2)^(3/2)
  EXPECT_NEAR(bhattacharyyaCoefficient(a, b, 0), expected, 1e-12);
  EXPECT_NEAR(bhattacharyyaCoefficient(b, a, 0), expected, 1e-12);
}

TEST(BhattacharyyaCoefficient, StaysInsideZeroAndOneOnFlatExtents) {
  std::mt19937 random(10);
  for (int k = 0; k < 200; ++k) {
    const Belief a{randomVector(random, 1), rotatedDiagonal(randomRotation(random), Vec3(1, 1, 0)), 1};
    const Belief b{randomVector(random, 1), rotatedDiagonal(randomRotation(random), Vec3(1, 0, 0)), 1};
    const double c = bhattacharyyaCoefficient(a, b, 0.01);
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
  }
}

}  // namespace
}  // namespace hgg::belief_test
