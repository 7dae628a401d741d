#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "eval/geometry.h"
#include "sim/random.h"

namespace hgg::geometry_eval_test {
namespace {

/// A square grid of points 0.1 m apart, spanned by u and v from `at`, `n` x `n`.
PointSet plane(const Vec3& at, const Vec3& u, const Vec3& v, int n) {
  PointSet points;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      points.emplace_back((at + 0.1 * i * u + 0.1 * j * v).cast<float>());
    }
  }
  return points;
}

PointSet floorAt(double height, int n = 20) { return plane(Vec3(0.05, 0.05, height), Vec3::UnitX(), Vec3::UnitY(), n); }

/// Floor and two walls: nothing can slide.
PointSet corner(const Vec3& at) {
  PointSet points = plane(at, Vec3::UnitX(), Vec3::UnitY(), 40);
  for (const auto& wall : {plane(at, Vec3::UnitX(), Vec3::UnitZ(), 30), plane(at, Vec3::UnitY(), Vec3::UnitZ(), 25)}) {
    points.insert(points.end(), wall.begin(), wall.end());
  }
  return points;
}

PointSet randomCloud(std::uint64_t seed, std::size_t n, double size) {
  PointSet points;
  for (std::uint64_t i = 0; i < n; ++i) {
    const RandomKey key{seed, i};
    points.emplace_back((size * Vec3(uniform(key, 0), uniform(key, 1), uniform(key, 2))).cast<float>());
  }
  return points;
}

TEST(MeasureGeometry, ShiftedPlanesAreApartByTheShift) {
  const GeometryScore s = measureGeometry(floorAt(0.25), floorAt(0), 0.01);
  EXPECT_NEAR(s.accuracy, 0.25, 1e-6);
  EXPECT_NEAR(s.completeness, 0.25, 1e-6);
  EXPECT_NEAR(s.chamfer, 0.25, 1e-6);
  EXPECT_EQ(s.estimate_points, 400u);
}

TEST(MeasureGeometry, EachSideIsMeasuredFromItsOwnPoints) {
  // The estimate is half of the reference: what there is is right, the other half is up to 1 m away.
  PointSet half;
  std::ranges::copy_if(floorAt(0), std::back_inserter(half), [](const auto& p) { return p.x() < 1.0F; });
  const GeometryScore s = measureGeometry(half, floorAt(0), 0.01);
  EXPECT_EQ(s.accuracy, 0.0);
  EXPECT_NEAR(s.completeness, 0.5 * (0.1 + 0.2 + 0.3 + 0.4 + 0.5 + 0.6 + 0.7 + 0.8 + 0.9 + 1.0) / 10, 1e-5);
  EXPECT_NEAR(s.chamfer, s.completeness / 2, 1e-12);
}

TEST(MeasureGeometry, DensePlacesWeighNoMore) {
  // 1000 more points in the one cell that lies 1 m above the floor.
  PointSet estimate = floorAt(0, 10);
  for (int i = 0; i < 1000; ++i) {
    estimate.emplace_back(0.05F, 0.05F, 1.05F);
  }
  EXPECT_NEAR(measureGeometry(estimate, floorAt(0, 10), 0.1).accuracy, 1.05 / 101, 1e-6);
}

TEST(MeasureGeometry, NothingHasNoScore) {
  EXPECT_TRUE(std::isnan(measureGeometry({}, floorAt(0), 0.1).chamfer));
  EXPECT_TRUE(std::isnan(compareGeometry(floorAt(0), {}, 0.1).chamfer));
  EXPECT_TRUE(std::isnan(compareGeometry({}, {}, 0.1).accuracy));
}

TEST(NearestDistances, EqualBruteForce) {
  const PointSet points = randomCloud(1, 300, 2.0), target = randomCloud(2, 400, 2.0);
  const auto distances = nearestDistances(points, target);
  for (std::size_t i = 0; i < points.size(); ++i) {
    float best = 1e9F;
    for (const auto& t : target) {
      best = std::min(best, (t - points[i]).norm());
    }
    ASSERT_NEAR(distances[i], best, 1e-6) << i;
  }
}

TEST(CropTo, EqualsBruteForceAndIncludesTheEdge) {
  const PointSet estimate = randomCloud(3, 40, 10.0), reference = randomCloud(4, 3000, 20.0);
  PointSet expected;
  std::ranges::copy_if(reference, std::back_inserter(expected), [&](const auto& p) {
    return std::ranges::any_of(estimate, [&](const auto& e) { return (e - p).squaredNorm() <= 9.0F; });
  });
  const PointSet cropped = cropTo(reference, estimate, 3.0);
  ASSERT_GT(cropped.size(), 100u);
  ASSERT_LT(cropped.size(), 2900u);
  EXPECT_EQ(cropped, expected);
  const PointSet at_edge = cropTo({{3, 0, 0}, {3.001F, 0, 0}}, {{0, 0, 0}}, 3.0);
  EXPECT_EQ(at_edge.size(), 1u);
}

TEST(CompareGeometry, ReferenceThatWasNeverPassedDoesNotCount) {
  PointSet reference = corner(Vec3::Zero());
  const PointSet far_room = corner(Vec3(30, 0, 0));
  reference.insert(reference.end(), far_room.begin(), far_room.end());
  const GeometryScore s = compareGeometry(corner(Vec3::Zero()), reference, 0.05);
  EXPECT_NEAR(s.completeness, 0.0, 1e-6);
  EXPECT_NEAR(s.chamfer, 0.0, 1e-6);
}

TEST(CoverageOf, TellsWhatAMapLeavesOut) {
  PointSet reference = corner(Vec3::Zero());
  const auto near = static_cast<double>(reference.size());
  for (int i = 0; i < 1000; ++i) {
    reference.emplace_back(30.0F, 0.1F * static_cast<float>(i), 0.0F);
  }
  EXPECT_DOUBLE_EQ(coverageOf(corner(Vec3::Zero()), reference), near / (near + 1000));
  EXPECT_EQ(coverageOf(reference, reference), 1.0);
  EXPECT_EQ(coverageOf({}, reference), 0.0);
  EXPECT_TRUE(std::isnan(coverageOf(reference, {})));
}

TEST(CompareGeometry, AlignmentTakesAwayARigidOffset) {
  Pose T = Pose::Identity();
  T.rotate(Eigen::AngleAxisd(0.02, Vec3(1, -1, 2).normalized()));
  T.pretranslate(Vec3(0.03, -0.04, 0.05));
  PointSet moved;
  for (const auto& p : corner(Vec3::Zero())) {
    moved.emplace_back((T * p.cast<double>()).cast<float>());
  }
  const GeometryScore s = compareGeometry(moved, corner(Vec3::Zero()), 0.05);
  EXPECT_NEAR(s.chamfer, 0.0, 1e-4);
  EXPECT_TRUE(s.T_reference_estimate.isApprox(T.inverse(), 1e-3));
}

TEST(Thin, KeepsTheFirstPointOfEachVoxel) {
  const PointSet points{{0.01F, 0, 0}, {0.09F, 0, 0}, {0.11F, 0, 0}, {-0.01F, 0, 0}, {0.19F, 0, 0}};
  EXPECT_EQ(thin(points, 0.1), (PointSet{{0.01F, 0, 0}, {0.11F, 0, 0}, {-0.01F, 0, 0}}));
}

Belief leaf(const Vec3& mean, const Vec3& deviations, const Mat3& R) {
  return {mean, R * deviations.cwiseAbs2().asDiagonal() * R.transpose(), 50};
}

TEST(SampleLeaves, KeepTheLeafsMoments) {
  const Mat3 R = Eigen::AngleAxisd(0.9, Vec3(2, 1, -1).normalized()).toRotationMatrix();
  const Belief b = leaf(Vec3(5, -3, 1), Vec3(0.4, 0.2, 0.01), R);
  const PointSet points = sampleLeaves(std::vector{b}, 0.01);
  ASSERT_GT(points.size(), 1000u);
  Moments moments(b.mean);
  for (const auto& p : points) {
    moments.add(p.x(), p.y(), p.z());
  }
  EXPECT_LT((moments.belief().mean - b.mean).norm(), 1e-3);
  EXPECT_LT((moments.belief().cov - b.cov).norm(), 1e-3);
}

TEST(SampleLeaves, FillTheBoxAndNothingElse) {
  const Belief b = leaf(Vec3(1, 2, 3), Vec3(0.3, 0.3, 0), Mat3::Identity());
  const double half = 0.3 * std::sqrt(3.0);
  const PointSet points = sampleLeaves(std::vector{b}, 0.1);
  EXPECT_EQ(points.size(), 121u);  // 11 x 11 x 1
  for (const auto& p : points) {
    EXPECT_LE(std::abs(p.x() - 1), half + 1e-6);
    EXPECT_NEAR(p.z(), 3.0F, 1e-6);
  }
  // No hole: every place of the patch has a sample within a spacing and a half.
  const PointSet patch = plane(Vec3(1 - half, 2 - half, 3), Vec3::UnitX(), Vec3::UnitY(), 11);
  EXPECT_LT(std::ranges::max(nearestDistances(patch, points)), 0.15);
}

TEST(SampleLeaves, AreTheSameEveryTimeAndAtLeastOneALeaf) {
  const Belief point = leaf(Vec3(1, 2, 3), Vec3::Zero(), Mat3::Identity());
  EXPECT_EQ(sampleLeaves(std::vector{point}, 0.1), (PointSet{{1, 2, 3}}));
  const Belief b = leaf(Vec3(1, 2, 3), Vec3(0.3, 0.2, 0.1), Mat3::Identity());
  EXPECT_EQ(sampleLeaves(std::vector{b}, 0.1), sampleLeaves(std::vector{b}, 0.1));
}

}  // namespace
}  // namespace hgg::geometry_eval_test
