#include "core/point_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "random_geometry.h"

namespace hgg::point_index_test {
namespace {

using Points = std::map<PointIndex::Id, Vec3>;

std::vector<PointIndex::Id> nearByBruteForce(const Points& points, const Vec3& centre, double radius) {
  std::vector<PointIndex::Id> ids;
  for (const auto& [id, p] : points) {
    if ((p - centre).squaredNorm() <= radius * radius) {
      ids.push_back(id);
    }
  }
  return ids;
}

/// An index and what should be in it.
struct Checked {
  PointIndex index;
  Points points;
  std::map<PointIndex::Id, double> reaches;
  PointIndex::Id next = 1;

  void insert(const Vec3& p) {
    index.insert(next, p);
    points[next++] = p;
  }
  /// A random one that is there.
  PointIndex::Id any(std::mt19937& random) const {
    return std::next(points.begin(),
                     static_cast<std::ptrdiff_t>(below(random, static_cast<std::uint32_t>(points.size()))))
        ->first;
  }
  void remove(PointIndex::Id id) {
    index.remove(index.find(id));
    points.erase(id), reaches.erase(id);
  }
  void move(PointIndex::Id id, const Vec3& p) {
    index.move(index.find(id), p);
    points[id] = p;
  }
  void reach(PointIndex::Id id, double reach) {
    index.setReach(index.find(id), reach);
    reaches[id] = reach;
  }

  std::vector<PointIndex::Id> reaching(const Vec3& p, double slack) const {
    std::vector<PointIndex::Id> ids;
    index.reaching(p, slack, [&](int handle) { ids.push_back(index.idOf(handle)); });
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  std::vector<PointIndex::Id> reachingByBruteForce(const Vec3& p, double slack) const {
    std::vector<PointIndex::Id> ids;
    for (const auto& [id, q] : points) {
      const auto it = reaches.find(id);
      const double reach = (it == reaches.end() ? 0 : it->second) + slack;
      if ((p - q).squaredNorm() <= reach * reach) {
        ids.push_back(id);
      }
    }
    return ids;
  }

  /// One of what can be done to it.
  void change(std::mt19937& random, double extent) {
    const std::uint32_t what = below(random, 10);
    if (points.empty() || what < 3) {
      insert(randomVector(random, extent));
    } else if (what < 5) {
      remove(any(random));
    } else if (what < 7) {
      const PointIndex::Id id = any(random);
      move(id, points[id] + randomVector(random, 0.3));
    } else if (what < 8) {
      move(any(random), randomVector(random, extent));
    } else {
      reach(any(random), std::exp(uniform(random, -3, 4)));
    }
  }
};

TEST(PointIndex, AnswersLikeBruteForceThroughEveryChange) {
  for (const double extent : {0.1, 5.0, 60.0, 3000.0}) {
    std::mt19937 random(1);
    Checked checked;
    for (int k = 0; k < 300; ++k) {
      checked.insert(randomVector(random, extent));
    }
    for (int step = 0; step < 3000; ++step) {
      checked.change(random, extent);
      const Vec3 centre = randomVector(random, 1.2 * extent);
      const double radius = extent * std::exp(uniform(random, -4, 1));
      ASSERT_EQ(checked.index.near(centre, radius), nearByBruteForce(checked.points, centre, radius)) << step;
      ASSERT_EQ(checked.reaching(centre, 0), checked.reachingByBruteForce(centre, 0)) << step;
      ASSERT_EQ(checked.reaching(centre, 0.7), checked.reachingByBruteForce(centre, 0.7)) << step;
      ASSERT_EQ(checked.index.size(), checked.points.size());
    }
  }
}

TEST(PointIndex, CanBeEmptiedAndFilledAgain) {
  std::mt19937 random(2);
  Checked checked;
  for (int round = 0; round < 5; ++round) {
    for (int k = 0; k < 200; ++k) {
      checked.insert(randomVector(random, 50 * (1 + round)));
    }
    while (!checked.points.empty()) {
      checked.remove(checked.any(random));
      ASSERT_EQ(checked.index.near(Vec3::Zero(), 60), nearByBruteForce(checked.points, Vec3::Zero(), 60));
    }
    EXPECT_EQ(checked.index.size(), 0U);
  }
  EXPECT_LE(checked.index.handleLimit(), 200U);  // free ones are used again
}

TEST(PointIndex, HoldsManyPointsOfOnePlaceAndOfPlacesOnItsCells) {
  Checked checked;
  for (int k = 0; k < 100; ++k) {
    checked.insert(Vec3(8, -16, 0));
    checked.insert(Vec3(k % 5, k % 7, k % 3) * 8);
  }
  for (const double radius : {0.0, 8.0, 16.0, 40.0}) {
    EXPECT_EQ(checked.index.near(Vec3(8, 8, 0), radius), nearByBruteForce(checked.points, Vec3(8, 8, 0), radius));
    EXPECT_EQ(checked.index.near(Vec3(8, -16, 0), radius), nearByBruteForce(checked.points, Vec3(8, -16, 0), radius));
  }
}

TEST(PointIndex, TakesAnyCoordinates) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  Checked checked;
  std::mt19937 random(3);
  for (const double far : {1e8, 1e12, 1e300, -1e300, infinity, -infinity, nan}) {
    for (int k = 0; k < 20; ++k) {
      checked.insert(Vec3(far, k, 0));
      checked.insert(randomVector(random, 30));
    }
  }
  for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(1e8, 0, 0), Vec3(1e300, 3, 0), Vec3(-1e12, 0, 0)}) {
    for (const double radius : {1.0, 50.0, 1e9}) {
      EXPECT_EQ(checked.index.near(centre, radius), nearByBruteForce(checked.points, centre, radius));
    }
  }
  while (!checked.points.empty()) {
    checked.remove(checked.points.begin()->first);
  }
  EXPECT_TRUE(checked.index.near(Vec3::Zero(), 1e9).empty());
}

TEST(PointIndex, SearchEndsWhereItsVisitorSays) {
  std::mt19937 random(4);
  PointIndex index;
  for (int k = 0; k < 500; ++k) {
    index.insert(k, randomVector(random, 40));
  }
  int visits = 0;
  EXPECT_TRUE(index.search(
      Vec3::Zero(), [](const CellBounds&, double) { return false; }, [&](int) { return ++visits == 7; }));
  EXPECT_EQ(visits, 7);
  EXPECT_FALSE(index.search(
      Vec3::Zero(), [](const CellBounds&, double) { return false; }, [](int) { return false; }));
  EXPECT_EQ(index.find(499) >= 0, true);
  EXPECT_EQ(index.find(500), -1);
}

TEST(PointIndex, AQueryLooksAtItsNeighbourhoodOnly) {
  std::mt19937 random(5);
  PointIndex index;
  for (int k = 0; k < 20000; ++k) {
    index.insert(k, Vec3(uniform(random, -1000, 1000), uniform(random, -1000, 1000), uniform(random, 0, 3)));
  }
  int looked_at = 0;
  index.search(
      Vec3::Zero(), [](const CellBounds&, double gap) { return gap > 20 * 20; },
      [&](int) {
        ++looked_at;
        return false;
      });
  const auto found = static_cast<int>(index.near(Vec3::Zero(), 20).size());
  EXPECT_GT(found, 0);
  EXPECT_LE(looked_at, 100) << "for " << found;
}

}  // namespace
}  // namespace hgg::point_index_test
