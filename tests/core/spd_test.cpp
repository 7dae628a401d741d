#include "core/spd.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "core/belief.h"
#include "random_geometry.h"

namespace hgg::spd_test {
namespace {

// The oracle: Eigen's general solver in extended precision, so that it is right to more digits than what it checks.
using Wide = Eigen::Matrix<long double, 3, 3>;
using WideVec = Eigen::Matrix<long double, 3, 1>;

template <typename Function>
Wide wideSpectral(const Wide& a, Function f) {
  const Eigen::SelfAdjointEigenSolver<Wide> solver(a);
  WideVec values = solver.eigenvalues();
  for (Eigen::Index k = 0; k < 3; ++k) {
    values[k] = f(values[k]);
  }
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

Wide widePower(const Wide& a, long double exponent) {
  return wideSpectral(a, [exponent](long double x) { return std::pow(std::max(x, 0.0L), exponent); });
}

double wideWasserstein2(const Belief& a, const Belief& b) {
  const Wide root = widePower(a.cov.cast<long double>(), 0.5L), cov_b = b.cov.cast<long double>();
  const long double overlap = widePower(root * cov_b * root, 0.5L).trace();
  const long double spread = a.cov.cast<long double>().trace() + cov_b.trace() - 2 * overlap;
  return static_cast<double>(std::sqrt((a.mean - b.mean).cast<long double>().squaredNorm() + std::max(spread, 0.0L)));
}

/// Flat, linear, round and skewed extents in random orientations.
std::vector<Mat3> extents(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Mat3> all;
  for (const Vec3& values : {Vec3(1, 1, 1e-6), Vec3(1, 1e-6, 1e-6), Vec3(1, 1e-3, 1e-6), Vec3(4, 0.25, 1e-6)}) {
    for (int k = 0; k < 20; ++k) {
      all.push_back(rotatedDiagonal(randomRotation(random), values));
    }
    all.emplace_back(values.asDiagonal());
  }
  for (int k = 0; k < 60; ++k) {
    all.push_back(randomSpd(random, 1e-4));
  }
  return all;
}

/// Two extents whose geodesic and distance are known: a = x x^T, b = x diag(ratios) x^T for any invertible x. Even the
/// extended oracle would lose digits on two needles that cross, where the ratios span twelve decades.
struct KnownPair {
  Wide x;
  WideVec ratios;
  Mat3 a() const { return (x * x.transpose()).cast<double>(); }
  Mat3 b() const { return (x * ratios.asDiagonal() * x.transpose()).cast<double>(); }
  Mat3 geodesic(long double gamma) const {
    return (x * ratios.array().pow(gamma).matrix().asDiagonal() * x.transpose()).cast<double>();
  }
  double distance() const { return static_cast<double>(std::sqrt(ratios.array().log().square().sum())); }
};

std::vector<KnownPair> knownPairs(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<KnownPair> all;
  for (const Vec3& deviations : {Vec3(1, 1, 1), Vec3(1, 1, 1e-3), Vec3(1, 1e-3, 1e-3), Vec3(2, 0.1, 0.01)}) {
    for (const Vec3& ratios :
         {Vec3(1, 2, 0.5), Vec3(3, 3, 3), Vec3(1e-3, 1, 40), Vec3(1, 1, 1e-6), Vec3(1e-3, 1e3, 1)}) {
      for (int k = 0; k < 10; ++k) {
        const Mat3 left = randomRotation(random), right = randomRotation(random);
        const Wide x =
            left.cast<long double>() * deviations.cast<long double>().asDiagonal() * right.cast<long double>();
        all.push_back({x, ratios.cast<long double>()});
      }
    }
  }
  return all;
}

/// Relative accuracy asked of round extents, and of flat ones, whose smallest eigenvalue a double holds to about 1e-10
/// only.
constexpr double kRound = 1e-13, kFlat = 1e-8;

/// The accuracy that the digits of two extents allow.
double attainable(const Mat3& a, const Mat3& b) {
  const auto condition = [](const Mat3& m) {
    const Eigen::SelfAdjointEigenSolver<Wide> solver(m.cast<long double>());
    return static_cast<double>(solver.eigenvalues()[2] / solver.eigenvalues()[0]);
  };
  return 1e-14 * std::max({condition(a), condition(b), 10.0});
}

void expectEigenDecomposition(const Mat3& a, const char* what) {
  const Eigen3 e = eigenSymmetric(a);
  const double scale = std::max(a.norm(), 1e-300);
  const Eigen::SelfAdjointEigenSolver<Wide> expected(a.cast<long double>());
  EXPECT_LE((e.values - expected.eigenvalues().cast<double>()).norm(), 1e-15 * 8 * scale) << what << "\n" << a;
  EXPECT_LE((a * e.vectors - e.vectors * e.values.asDiagonal()).norm(), 1e-15 * 8 * scale) << what << "\n" << a;
  EXPECT_LE((e.vectors.transpose() * e.vectors - Mat3::Identity()).norm(), 1e-14) << what;
  EXPECT_NEAR(e.vectors.determinant(), 1, 1e-14) << what << ": left-handed";
  EXPECT_TRUE(e.values[0] <= e.values[1] && e.values[1] <= e.values[2]) << what << ": " << e.values.transpose();
}

TEST(EigenSymmetric, AgreesWithTheGeneralSolver) {
  std::mt19937 random(1);
  for (int k = 0; k < 500; ++k) {
    const Mat3 m = Mat3::NullaryExpr([&](Eigen::Index, Eigen::Index) { return uniform(random, -5, 5); });
    expectEigenDecomposition(m + m.transpose(), "random");
    expectEigenDecomposition(rotatedDiagonal(randomRotation(random), Vec3(2, 2, 5)), "repeated pair");
    expectEigenDecomposition(rotatedDiagonal(randomRotation(random), Vec3(3, 3, 3)), "all equal");
    const Vec3 v = randomVector(random, 3);
    expectEigenDecomposition(v * v.transpose(), "rank 1");
    expectEigenDecomposition(rotatedDiagonal(randomRotation(random), Vec3(1, 1e-6, 1e-12)), "ratios of 1e-6");
  }
}

TEST(EigenSymmetric, TakesDiagonalAndZeroMatricesAndAnyScale) {
  for (const Vec3& values :
       {Vec3(1, 2, 3), Vec3(3, 2, 1), Vec3(2, 3, 1), Vec3(0, 0, 1), Vec3(-1, 0, 1), Vec3(0, 0, 0)}) {
    expectEigenDecomposition(values.asDiagonal(), "diagonal");
  }
  std::mt19937 random(2);
  for (const double scale : {1e-200, 1e-30, 1e-9, 1e9, 1e30}) {
    expectEigenDecomposition(scale * randomSpd(random, 1e-3), "scaled");
  }
}

TEST(EigenSymmetric, KeepsTheDigitsOfSmallEigenvaluesOfGradedMatrices) {
  // Entries that fall off with their indices pin the small eigenvalue to full relative accuracy; a solver that first
  // reduces to tridiagonal form would lose it.
  Mat3 a;
  a << 1e-12, 0.3e-9, 0.2e-6, 0.3e-9, 1e-6, 0.1e-3, 0.2e-6, 0.1e-3, 1;
  const Wide wide = a.cast<long double>();
  const Eigen::SelfAdjointEigenSolver<Wide> solver(wide);
  const long double smallest = wide.determinant() / (solver.eigenvalues()[1] * solver.eigenvalues()[2]);
  EXPECT_NEAR(eigenSymmetric(a).values[0] / static_cast<double>(smallest), 1, 1e-6);
}

TEST(SpdSqrt, SquaresToItsArgument) {
  for (const Mat3& a : extents(3)) {
    const Mat3 root = spdSqrt(a);
    EXPECT_LE(relativeError(root * root, a), kRound);
    EXPECT_LE(relativeError(root, widePower(a.cast<long double>(), 0.5L).cast<double>()), kFlat);
  }
}

TEST(SpdSqrt, TakesSemiDefiniteMatrices) {
  const Vec3 v(1, 2, -2);
  EXPECT_LE(relativeError(spdSqrt(v * v.transpose()), v * v.transpose() / 3), 1e-8);  // rounding of 1e-16 under a root
  EXPECT_EQ(spdSqrt(Mat3::Zero()), Mat3::Zero());
}

TEST(SpdLog, AgreesWithTheGeneralSolverAndExpUndoesIt) {
  for (const Mat3& a : extents(4)) {
    const Mat3 log = spdLog(a);
    const Wide expected = wideSpectral(a.cast<long double>(), [](long double x) { return std::log(x); });
    EXPECT_LE(relativeError(log, expected.cast<double>()), kFlat);
    EXPECT_LE(relativeError(symExp(log), a), 1e-12);
  }
}

TEST(SymExp, EqualsThePowerSeriesOnIndefiniteMatrices) {
  std::mt19937 random(5);
  for (int k = 0; k < 100; ++k) {
    const Mat3 a = rotatedDiagonal(randomRotation(random), randomVector(random, 2));
    Wide sum = Wide::Identity(), term = Wide::Identity();
    for (int n = 1; n < 60; ++n) {
      term = term * a.cast<long double>() / static_cast<long double>(n);
      sum += term;
    }
    EXPECT_LE(relativeError(symExp(a), sum.cast<double>()), kRound);
  }
}

TEST(SpdPower, ExponentsAddAndMinusOneInverts) {
  for (const Mat3& a : extents(6)) {
    EXPECT_LE(relativeError(spdPower(a, 0.3) * spdPower(a, 0.7), a), 1e-12);
    EXPECT_LE(relativeError(spdPower(a, 0.5), spdSqrt(a)), kRound);
    EXPECT_LE(relativeError(spdPower(a, -1), a.cast<long double>().inverse().eval().cast<double>()), kFlat);
    EXPECT_LE((spdPower(a, 0) - Mat3::Identity()).norm(), kRound);
  }
}

TEST(SpdGeodesic, StartsAndEndsAtItsArguments) {
  const std::vector<Mat3> all = extents(7);
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    EXPECT_LE(relativeError(spdGeodesic(all[k], all[k + 1], 0), all[k]), 1e-10);
    EXPECT_LE(relativeError(spdGeodesic(all[k], all[k + 1], 1), all[k + 1]), kRound);
  }
}

TEST(SpdGeodesic, HitsPairsOfKnownGeodesic) {
  for (const KnownPair& pair : knownPairs(8)) {
    for (const double gamma : {0.1, 0.5, 0.75}) {
      EXPECT_LE(relativeError(spdGeodesic(pair.a(), pair.b(), gamma), pair.geodesic(gamma)),
                attainable(pair.a(), pair.b()))
          << "a\n"
          << pair.a() << "\nratios " << pair.ratios.cast<double>().transpose() << ", gamma " << gamma;
    }
  }
}

TEST(SpdGeodesic, IsEquivariantUnderCongruence) {
  std::mt19937 random(9);
  for (int k = 0; k < 100; ++k) {
    const Mat3 a = randomSpd(random, 1e-4), b = randomSpd(random, 1e-4);
    const Mat3 x = randomRotation(random) * Vec3(0.3, 1, 4).asDiagonal() * randomRotation(random);
    const Mat3 moved = spdGeodesic(x * a * x.transpose(), x * b * x.transpose(), 0.4);
    EXPECT_LE(relativeError(moved, x * spdGeodesic(a, b, 0.4) * x.transpose()), 1e-10);
  }
}

TEST(SpdGeodesic, InterpolatesTheLogDeterminantAndTheDistance) {
  std::mt19937 random(10);
  for (int k = 0; k < 100; ++k) {
    const Mat3 a = randomSpd(random, 1e-4), b = randomSpd(random, 1e-4);
    for (const double gamma : {0.25, 0.5, 0.9}) {
      const Mat3 g = spdGeodesic(a, b, gamma);
      EXPECT_NEAR(std::log(g.determinant()),
                  (1 - gamma) * std::log(a.determinant()) + gamma * std::log(b.determinant()), 1e-9);
      EXPECT_NEAR(affineInvariantDistance(a, g), gamma * affineInvariantDistance(a, b), 1e-9);
    }
  }
}

TEST(AffineInvariantDistance, HitsPairsOfKnownDistance) {
  for (const KnownPair& pair : knownPairs(11)) {
    EXPECT_NEAR(affineInvariantDistance(pair.a(), pair.b()), pair.distance(),
                attainable(pair.a(), pair.b()) * pair.distance())
        << "a\n"
        << pair.a() << "\nratios " << pair.ratios.cast<double>().transpose();
  }
}

TEST(AffineInvariantDistance, IsSymmetricAndZeroOnlyOnItself) {
  const std::vector<Mat3> all = extents(12);
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    const double d = affineInvariantDistance(all[k], all[k + 1]);
    EXPECT_NEAR(affineInvariantDistance(all[k + 1], all[k]), d, 1e-9 * std::max(d, 1.0));
    EXPECT_LE(affineInvariantDistance(all[k], all[k]), 1e-9);
    EXPECT_GE(d, 1e-3);
  }
}

TEST(AffineInvariantDistance, IsInvariantUnderCongruenceAndInversion) {
  std::mt19937 random(13);
  for (int k = 0; k < 200; ++k) {
    const Mat3 a = randomSpd(random, 1e-4), b = randomSpd(random, 1e-4);
    const Mat3 x = randomRotation(random) * Vec3(0.2, 1, 7).asDiagonal() * randomRotation(random);
    const double d = affineInvariantDistance(a, b);
    EXPECT_NEAR(affineInvariantDistance(x * a * x.transpose(), x * b * x.transpose()), d, 1e-9 * d);
    EXPECT_NEAR(affineInvariantDistance(a.inverse(), b.inverse()), d, 1e-8 * d);
  }
}

TEST(AffineInvariantDistance, HoldsTheTriangleInequality) {
  std::mt19937 random(14);
  for (int k = 0; k < 300; ++k) {
    const Mat3 a = randomSpd(random, 1e-3), b = randomSpd(random, 1e-3), c = randomSpd(random, 1e-3);
    EXPECT_LE(affineInvariantDistance(a, c), affineInvariantDistance(a, b) + affineInvariantDistance(b, c) + 1e-12);
  }
}

TEST(Mahalanobis, AgreesWithTheInverse) {
  std::mt19937 random(15);
  for (const Mat3& s : extents(15)) {
    const Vec3 d = randomVector(random, 3);
    const WideVec wide = d.cast<long double>();
    const auto expected = static_cast<double>(std::sqrt(wide.dot(s.cast<long double>().inverse().eval() * wide)));
    EXPECT_NEAR(mahalanobis(d, s), expected, 1e-9 * expected);
  }
}

TEST(WithFloor, AddsTheVarianceToEveryDirection) {
  const Vec3 v(3, 4, 0);
  const Mat3 line = v * v.transpose();
  const Eigen3 e = eigenSymmetric(withFloor(line, 0.01));
  EXPECT_LE((e.values - Vec3(1e-4, 1e-4, 25 + 1e-4)).norm(), 1e-12);
}

TEST(Wasserstein2, AgreesWithTheFormula) {
  std::mt19937 random(16);
  const std::vector<Mat3> all = extents(16);
  for (std::size_t k = 0; k + 1 < all.size(); ++k) {
    for (const double apart : {0.0, 0.1, 30.0}) {
      const Belief a{randomVector(random, 1), all[k], 1}, b{a.mean + Vec3(apart, 0, 0), all[k + 1], 1};
      const double expected = wideWasserstein2(a, b);
      EXPECT_NEAR(wasserstein2(a, b), expected, 1e-9 * expected) << "pair " << k;
      EXPECT_NEAR(wasserstein2(b, a), expected, 1e-9 * expected) << "pair " << k;
    }
  }
}

TEST(Wasserstein2, OfAxesAlignedExtentsIsTheDifferenceOfTheirDeviations) {
  const Belief a{Vec3(1, 2, 3), Vec3(4, 1, 0.09).asDiagonal(), 1}, b{Vec3(1, 2, 7), Vec3(1, 9, 0.16).asDiagonal(), 1};
  EXPECT_NEAR(wasserstein2(a, b), std::sqrt(16 + 1 + 4 + 0.01), 1e-12);
}

TEST(Wasserstein2, TakesFlatLinearAndPointExtents) {
  const Vec3 v(1, 2, -2), u(2, 1, 2);  // orthogonal, 3 m each
  const Belief point{Vec3(0, 0, 0), Mat3::Zero(), 1}, far_point{Vec3(3, 4, 0), Mat3::Zero(), 1};
  const Belief line{Vec3(0, 0, 0), v * v.transpose(), 1}, cross{Vec3(0, 0, 0), u * u.transpose(), 1};
  EXPECT_DOUBLE_EQ(wasserstein2(point, far_point), 5);
  EXPECT_NEAR(wasserstein2(point, line), 3, 1e-12);
  EXPECT_NEAR(wasserstein2(line, cross), std::sqrt(18), 1e-7);
  EXPECT_NEAR(wasserstein2(line, line), 0, 1e-6);
}

TEST(Wasserstein2, IsAMetricThatRigidMotionLeavesAlone) {
  std::mt19937 random(17);
  for (int k = 0; k < 300; ++k) {
    const Belief a = randomBelief(random, 1), b = randomBelief(random, 1), c = randomBelief(random, 1);
    EXPECT_LE(wasserstein2(a, c), wasserstein2(a, b) + wasserstein2(b, c) + 1e-12);
    EXPECT_GE(wasserstein2(a, b), (a.mean - b.mean).norm() - 1e-12);
    const Pose T = randomPose(random, 10);
    EXPECT_NEAR(wasserstein2(transform(T, a), transform(T, b)), wasserstein2(a, b), 1e-9);
    EXPECT_LE(wasserstein2(a, a), 1e-6);
  }
}

TEST(NuclearNormOfRoots, HoldsOnRankDeficientPairs) {
  std::mt19937 random(18);
  for (int k = 0; k < 300; ++k) {
    const Mat3 flat = rotatedDiagonal(randomRotation(random), Vec3(1, 0.5, 0));
    const Vec3 v = randomVector(random, 1);
    // tr (b^(1/2) a b^(1/2))^(1/2) of b = v v^T is sqrt(v^T a v).
    EXPECT_NEAR(nuclearNormOfRoots(flat, v * v.transpose()), std::sqrt(v.dot(flat * v)), 1e-7);
    EXPECT_NEAR(nuclearNormOfRoots(v * v.transpose(), flat), std::sqrt(v.dot(flat * v)), 1e-7);
  }
}

}  // namespace
}  // namespace hgg::spd_test
