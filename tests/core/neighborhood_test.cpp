#include "core/neighborhood.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hgg::neighborhood_test {
namespace {

using Edges = std::vector<std::pair<int, int>>;

/// The definition, word for word.
Edges bruteForce(const std::vector<Vec3>& p) {
  Edges edges;
  const int n = static_cast<int>(p.size());
  const auto d = [&](int i, int j) {
    return (p[static_cast<std::size_t>(i)] - p[static_cast<std::size_t>(j)]).squaredNorm();
  };
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      bool blocked = false;
      for (int k = 0; k < n && !blocked; ++k) {
        blocked = k != i && k != j && std::max(d(i, k), d(j, k)) < d(i, j);
      }
      if (!blocked) {
        edges.emplace_back(i, j);
      }
    }
  }
  return edges;
}

std::vector<Vec3> randomPoints(std::mt19937& random, int n, const Vec3& extent) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(extent.cwiseProduct(Vec3(unit(random), unit(random), unit(random))));
  }
  return points;
}

TEST(RelativeNeighborhood, EqualsBruteForceUpTo500Nodes) {
  std::mt19937 random(3);
  for (const int n : {0, 1, 2, 3, 4, 9, 10, 50, 200, 500}) {
    for (const Vec3& extent : {Vec3(50, 50, 50), Vec3(80, 80, 2), Vec3(100, 0, 0)}) {
      const std::vector<Vec3> points = randomPoints(random, n, extent);
      EXPECT_EQ(relativeNeighborhood(points), bruteForce(points)) << n << " points in " << extent.transpose();
    }
  }
}

TEST(RelativeNeighborhood, EqualsBruteForceWhereDistancesTie) {
  std::vector<Vec3> lattice;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      for (int z = 0; z < 3; ++z) {
        lattice.emplace_back(x, y, z);
      }
    }
  }
  lattice.emplace_back(0, 0, 0);  // and a copy
  EXPECT_EQ(relativeNeighborhood(lattice), bruteForce(lattice));
}

TEST(RelativeNeighborhood, IsConnected) {
  std::mt19937 random(4);
  const std::vector<Vec3> points = randomPoints(random, 300, Vec3(80, 80, 5));
  std::vector<int> component(points.size());
  for (std::size_t i = 0; i < component.size(); ++i) {
    component[i] = static_cast<int>(i);
  }
  for (const auto& [a, b] : relativeNeighborhood(points)) {
    const int from = component[static_cast<std::size_t>(b)], to = component[static_cast<std::size_t>(a)];
    std::replace(component.begin(), component.end(), from, to);
  }
  EXPECT_EQ(component, std::vector<int>(points.size(), component[0]));
}

}  // namespace
}  // namespace hgg::neighborhood_test
