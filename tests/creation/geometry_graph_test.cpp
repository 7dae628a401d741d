#include "creation/geometry_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_geometry.h"

namespace hgg::geometry_graph_test {
namespace {

using Cloud = std::vector<PackedPoint>;

const RadiusLaw kAnyGap{1e6F, 0};  // leaves may bridge anything

Belief beliefOf(std::span<const PackedPoint> points) {
  std::vector<Vec3> wide;
  for (const PackedPoint& p : points) {
    wide.emplace_back(p[0], p[1], p[2]);
  }
  return beliefFromPoints(wide);
}

void expectSame(const Belief& actual, const Belief& expected, double tolerance) {
  EXPECT_LE((actual.mean - expected.mean).norm(), tolerance);
  EXPECT_LE((actual.cov - expected.cov).norm(), tolerance);
  EXPECT_EQ(actual.kappa, expected.kappa);
}

/// Shapes that stress a k-d partition, each of n points 10 .. 30 m away.
std::vector<Cloud> shapes(int n) {
  std::mt19937 random(1);
  const auto at = [](const Vec3& p) {
    return PackedPoint(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0);
  };
  Cloud box, plane, line, sliver, copies, two_places;
  const Mat3 R = randomRotation(random);
  for (int i = 0; i < n; ++i) {
    const Vec3 u = randomVector(random, 1);
    box.push_back(at(Vec3(20, 5, 1) + R * u.cwiseProduct(Vec3(2, 1, 0.5))));
    plane.push_back(at(Vec3(-10, 5, 1) + R * u.cwiseProduct(Vec3(2, 1, 0))));
    line.push_back(at(Vec3(10, 0, 0) + u.x() * Vec3(0, 1, 2)));
    sliver.push_back(
        at(Vec3(10 + std::pow(0.5, i % 40), 0, 0)));  // a mean that cuts off next to nothing, level after level
    copies.push_back(at(Vec3(12.3, -4.5, 6.7)));
    two_places.push_back(at(Vec3(std::nextafter(10.0F, i % 7 == 0 ? 11.0F : 10.0F), 0, 0)));  // neighbouring floats
  }
  return {box, plane, line, sliver, copies, two_places};
}

/// Widest gap between neighbours along the axis on which the points spread most.
float widestGap(std::span<const PackedPoint> points) {
  PackedPoint low = points[0], high = points[0];
  for (const PackedPoint& p : points) {
    low = low.min(p), high = high.max(p);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::vector<float> along;
  for (const PackedPoint& p : points) {
    along.push_back(p[axis]);
  }
  std::sort(along.begin(), along.end());
  float widest = 0;
  for (std::size_t k = 1; k < along.size(); ++k) {
    widest = std::max(widest, along[k] - along[k - 1]);
  }
  return widest;
}

TEST(ObjectFrame, IsRightHandedAlongTheEigenvectorsLongestFirst) {
  std::mt19937 random(2);
  for (int k = 0; k < 200; ++k) {
    const Belief b{randomVector(random, 100),
                   k % 2 == 0 ? randomSpd(random, 1e-6) : rotatedDiagonal(randomRotation(random), Vec3(1, 0, 0)), 5};
    const Pose T = objectFrame(b);
    EXPECT_EQ(T.translation(), b.mean);
    EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
    EXPECT_LE((T.linear().transpose() * T.linear() - Mat3::Identity()).norm(), 1e-12);
    const Mat3 in_frame = T.linear().transpose() * b.cov * T.linear();
    EXPECT_LE((in_frame - Mat3(in_frame.diagonal().asDiagonal())).norm(), 1e-12);
    EXPECT_TRUE(in_frame(0, 0) >= in_frame(1, 1) - 1e-12 && in_frame(1, 1) >= in_frame(2, 2) - 1e-12);
  }
}

TEST(ObjectFrame, OfASinglePointIsAFrame) {
  const Pose T = objectFrame({Vec3(1, 2, 3), Mat3::Zero(), 1});
  EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
  EXPECT_EQ(T.translation(), Vec3(1, 2, 3));
}

TEST(PartitionLeaves, HoldAtMostLeafPointsAndTogetherAllOfThem) {
  for (const int n : {1, 2, 63, 64, 65, 1000}) {
    for (const int leaf_points : {1, 3, 64}) {
      for (Cloud& cloud : shapes(n)) {
        double sum = 0;
        for (const LocalLeaf& leaf : partitionLeaves(cloud, Pose::Identity(), leaf_points, kAnyGap)) {
          EXPECT_GE(leaf.kappa, 1);
          EXPECT_TRUE(leaf.kappa <= leaf_points || leaf.cov.isZero()) << leaf.kappa;  // copies of a point stay together
          sum += leaf.kappa;
        }
        EXPECT_EQ(sum, n) << leaf_points << " a leaf";
      }
    }
  }
}

TEST(PartitionLeaves, MergeBackIntoTheObjectInTheBodyFrame) {
  for (Cloud& cloud : shapes(1000)) {
    const Belief object = beliefOf(cloud);
    const Pose T_body_object = objectFrame(object);
    Belief merged;
    for (const LocalLeaf& leaf : partitionLeaves(cloud, T_body_object, 16, kAnyGap)) {
      merged = merge(merged, transform(T_body_object, leaf));
    }
    expectSame(merged, object, 1e-9);
  }
}

TEST(PartitionLeaves, AreTheBeliefsOfTheirOwnPoints) {
  for (Cloud& cloud : shapes(500)) {
    const Pose T_body_object = objectFrame(beliefOf(cloud));
    std::size_t begin = 0;
    for (const LocalLeaf& leaf : partitionLeaves(cloud, T_body_object, 10, kAnyGap)) {
      const auto points = std::span(cloud).subspan(begin, static_cast<std::size_t>(leaf.kappa));
      expectSame(transform(T_body_object, leaf), beliefOf(points), 1e-9);
      begin += points.size();
    }
    EXPECT_EQ(begin, cloud.size());
  }
}

TEST(PartitionLeaves, KeepTheSamePointsInWhateverOrder) {
  const auto sorted = [](Cloud cloud) {
    std::sort(cloud.begin(), cloud.end(), [](const PackedPoint& p, const PackedPoint& q) {
      return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    });
    std::vector<float> flat;
    for (const PackedPoint& p : cloud) {
      flat.insert(flat.end(), p.begin(), p.end());
    }
    return flat;
  };
  for (Cloud& cloud : shapes(300)) {
    const auto before = sorted(cloud);
    partitionLeaves(cloud, Pose::Identity(), 8, kAnyGap);
    EXPECT_EQ(sorted(cloud), before);
  }
}

TEST(PartitionLeaves, CompactLeavesComeFromCuttingTheWidestAxis) {
  // A 16 m fence of unit width: its 16 leaves are pieces of about a metre, not strips along it.
  std::mt19937 random(3);
  Cloud fence;
  for (int i = 0; i < 1600; ++i) {
    fence.emplace_back(static_cast<float>(uniform(random, 5, 21)), static_cast<float>(uniform(random, 0, 1)), 0.0F,
                       0.0F);
  }
  const std::vector<LocalLeaf> leaves = partitionLeaves(fence, Pose::Identity(), 128, kAnyGap);
  EXPECT_GE(leaves.size(), 13U);
  for (const LocalLeaf& leaf : leaves) {
    EXPECT_LE(std::sqrt(leaf.cov(0, 0)), 0.6) << "standard deviation along the fence";
  }
}

TEST(PartitionLeaves, SpanNoGapWiderThanTheBridge) {
  std::mt19937 random(4);
  for (int round = 0; round < 30; ++round) {
    Cloud clumps;
    for (int c = 0; c < 12; ++c) {
      const Vec3 at = Vec3(15, 0, 0) + randomVector(random, 5);
      for (std::uint32_t k = 1 + below(random, 6); k > 0; --k) {
        const Vec3 p = at + randomVector(random, 0.2);
        clumps.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F);
      }
    }
    const std::size_t n = clumps.size();
    std::size_t begin = 0;
    for (const LocalLeaf& leaf : partitionLeaves(clumps, Pose::Identity(), 1000, {1.0F, 0})) {
      const auto points = std::span(clumps).subspan(begin, static_cast<std::size_t>(leaf.kappa));
      begin += points.size();
      EXPECT_LE(widestGap(points), 1.0F);
    }
    EXPECT_EQ(begin, n);
  }
}

TEST(PartitionLeaves, BridgeMoreTheFartherThePointsAre) {
  for (const float range : {10.0F, 60.0F}) {
    Cloud pair{{range, 0, 0, 0}, {range, 1.5F, 0, 0}};
    EXPECT_EQ(partitionLeaves(pair, Pose::Identity(), 64, {1.0F, 0.03F}).size(), range < 50 ? 2U : 1U);
  }
}

TEST(PartitionLeaves, ManyCopiesOfAPointAreOneLeaf) {
  Cloud cloud(200000, PackedPoint(1, 2, 3, 0));
  const std::vector<LocalLeaf> leaves = partitionLeaves(cloud, Pose::Identity(), 64, kAnyGap);
  ASSERT_EQ(leaves.size(), 1U);  // thousands of coincident leaves would all be neighbours of each other
  EXPECT_EQ(leaves[0].mean, Vec3(1, 2, 3));
  EXPECT_EQ(leaves[0].cov, Mat3::Zero());
  EXPECT_EQ(leaves[0].kappa, 200000);
}

TEST(PartitionLeaves, OfNothingAreNone) { EXPECT_TRUE(partitionLeaves({}, Pose::Identity(), 8, kAnyGap).empty()); }

}  // namespace
}  // namespace hgg::geometry_graph_test
