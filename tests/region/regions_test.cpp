#include "region/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "map/test_map.h"
#include "region/groups.h"

namespace hgg::regions_test {
namespace {

constexpr ClassId kWall = 1, kFloor = 2, kCeiling = 3, kChair = 10, kBed = 14, kCar = 20, kPole = 21;
constexpr double kLeaf = 0.2;                    // m, edge of a leaf
constexpr double kHeight = 2.5, kFloorZ = -0.7;  // m; the sensor of the only keyframe is at the origin

/// Draws buildings as leaves of stuff.
class Builder {
 public:
  Builder() {
    for (const ClassId label : {kWall, kFloor, kCeiling}) {
      stuff_.push_back(tileNode(label, {static_cast<std::int32_t>(label), 0, 0}, Vec3::Zero()));
      stuff_.back().T_map_object = Pose::Identity();
    }
  }

  /// Floor and ceiling over a rectangle, the floor at `z`.
  void floor(double x0, double y0, double x1, double y1, double z = kFloorZ) {
    for (double x = x0 + kLeaf / 2; x < x1; x += kLeaf) {
      for (double y = y0 + kLeaf / 2; y < y1; y += kLeaf) {
        add(1, Vec3(x, y, z), Vec3(1, 1, 0)), add(2, Vec3(x, y, z + kHeight), Vec3(1, 1, 0));
      }
    }
  }
  /// A wall along one axis.
  void wall(double x0, double y0, double x1, double y1, double z = kFloorZ) {
    const Vec3 way(x1 - x0, y1 - y0, 0), along = way.cwiseAbs().normalized();
    for (double s = kLeaf / 2; s < way.norm(); s += kLeaf) {
      for (double up = kLeaf / 2; up < kHeight; up += kLeaf) {
        add(0, Vec3(x0, y0, z + up) + s * way.normalized(), along + Vec3::UnitZ());
      }
    }
  }
  void room(double x0, double y0, double x1, double y1, double z = kFloorZ) {
    floor(x0, y0, x1, y1, z);
    wall(x0, y0, x1, y0, z), wall(x0, y1, x1, y1, z), wall(x0, y0, x0, y1, z), wall(x1, y0, x1, y1, z);
  }
  void thing(ClassId label, double x, double y, double z = kFloorZ + 0.5) {
    things_.push_back(nodeAt(label, Vec3(x, y, z), 0.15));
    addLeaf(things_.back(), packLeaf({Vec3::Zero(), 0.02 * Mat3::Identity(), 100}));
  }
  std::vector<MapNode> all() const {
    std::vector<MapNode> nodes = stuff_;
    nodes.insert(nodes.end(), things_.begin(), things_.end());
    return nodes;
  }
  /// The map, its things in the order that the seed gives.
  Map map(unsigned seed = 0) const {
    std::vector<MapNode> nodes = all();
    std::mt19937 random(seed);
    if (seed > 0) {
      std::ranges::shuffle(nodes, random);
    }
    Map map = mapOf(nodes);
    map.setClassNames({{kWall, "wall"},
                       {kFloor, "floor"},
                       {kCeiling, "ceiling"},
                       {kChair, "chair"},
                       {kBed, "bed"},
                       {kCar, "car"},
                       {kPole, "pole"}});
    return map;
  }

 private:
  /// A square leaf that extends along the axes that `axes` has.
  void add(std::size_t node, const Vec3& mean, const Vec3& axes) {
    constexpr double kThin = 1e-3;  // m
    const Vec3 deviations = axes * (kLeaf / std::sqrt(12.0)) + Vec3::Constant(kThin);
    addLeaf(stuff_[node], packLeaf({mean, deviations.cwiseAbs2().asDiagonal(), 100}));
  }

  std::vector<MapNode> stuff_, things_;
};

/// The oracle: pairs that no third point is nearer to on both sides than they are to each other.
std::vector<std::pair<int, int>> rngByBruteForce(const std::vector<Vec3>& points) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const double length = (points[i] - points[j]).norm();
      if (std::ranges::none_of(points, [&](const Vec3& k) {
            return std::max((k - points[i]).norm(), (k - points[j]).norm()) < length;
          })) {
        pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
      }
    }
  }
  return pairs;
}

/// Where the things of each region are: what does not depend on ids.
std::set<std::set<std::pair<double, double>>> placesOf(const Map& map, const Regions& found) {
  std::set<std::set<std::pair<double, double>>> all;
  for (const Region& region : found.regions) {
    std::set<std::pair<double, double>> places;
    for (const NodeId id : region.objects) {
      places.emplace(map.find(id)->belief.mean.x(), map.find(id)->belief.mean.y());
    }
    all.insert(places);
  }
  return all;
}

/// Two rooms of 4 m with a door of 0.9 m between them, and two things in each.
Builder twoRooms() {
  Builder builder;
  builder.floor(-4, -2, 4, 2);
  builder.wall(-4, -2, 4, -2), builder.wall(-4, 2, 4, 2), builder.wall(-4, -2, -4, 2), builder.wall(4, -2, 4, 2);
  builder.wall(0, -2, 0, 0.6), builder.wall(0, 1.5, 0, 2);
  builder.thing(kBed, -3, -1), builder.thing(kChair, -1, 1);
  builder.thing(kChair, 1, 1), builder.thing(kChair, 3, -1);
  return builder;
}

TEST(Regions, TwoRoomsWithADoorBetweenStayTwo) {
  const Map map = twoRooms().map();
  EXPECT_EQ(placesOf(map, findRegions(map)),
            (std::set<std::set<std::pair<double, double>>>{{{-3, -1}, {-1, 1}}, {{1, 1}, {3, -1}}}));
}

TEST(Regions, ThingsBesideAWallAreInTheRoomOnTheirSide) {
  Builder builder = twoRooms();
  builder.thing(kChair, -0.15, -1), builder.thing(kChair, 0.15, -1);
  const Map map = builder.map();
  EXPECT_EQ(placesOf(map, findRegions(map)), (std::set<std::set<std::pair<double, double>>>{
                                                 {{-3, -1}, {-1, 1}, {-0.15, -1}}, {{0.15, -1}, {1, 1}, {3, -1}}}));
}

TEST(Regions, AHallWithAPillarAndAKioskStaysOne) {
  Builder builder;
  builder.room(-8, -4, 8, 4);
  for (const auto& [x, size] : {std::pair(-3.0, 0.6), std::pair(2.0, 2.0)}) {  // m
    builder.wall(x, -size / 2, x + size, -size / 2), builder.wall(x, size / 2, x + size, size / 2);
    builder.wall(x, -size / 2, x, size / 2), builder.wall(x + size, -size / 2, x + size, size / 2);
  }
  for (const double x : {-7.0, -1.0, 1.0, 7.0}) {
    builder.thing(kChair, x, -3), builder.thing(kChair, x, 3);
  }
  EXPECT_EQ(findRegions(builder.map()).regions.size(), 1U);
}

/// Walls that meet between three doors touch no other wall, and ground is all around them, as around a kiosk.
TEST(Regions, WallsThatMeetBetweenDoorsAreWalls) {
  Builder builder;
  builder.room(-3, -2.5, 3, 2.5);
  builder.wall(-2.1, 0, 2.1, 0), builder.wall(0, 0, 0, 1.6);
  for (const double x : {-2.0, 2.0}) {
    builder.thing(kChair, x, -1.5), builder.thing(kBed, x, 2);
  }
  const Map map = builder.map();
  EXPECT_EQ(placesOf(map, findRegions(map)),
            (std::set<std::set<std::pair<double, double>>>{{{-2, -1.5}, {2, -1.5}}, {{-2, 2}}, {{2, 2}}}));
}

TEST(Regions, AnAngledCorridorIsOneAndTheRoomsOffItAreTheirOwn) {
  Builder builder;
  builder.floor(0, 0, 12, 1.6), builder.floor(10.4, 1.6, 12, 10);
  builder.wall(0, 0, 12, 0), builder.wall(0, 0, 0, 1.6), builder.wall(12, 0, 12, 10), builder.wall(10.4, 10, 12, 10);
  builder.wall(10.4, 1.6, 10.4, 10), builder.wall(0, 1.6, 2, 1.6), builder.wall(2.9, 1.6, 10.4, 1.6);
  builder.floor(0, 1.6, 5, 5);  // a room with a door at x = 2 to 2.9
  builder.wall(0, 1.6, 0, 5), builder.wall(5, 1.6, 5, 5), builder.wall(0, 5, 5, 5);
  builder.thing(kChair, 0.5, 0.4), builder.thing(kChair, 6, 0.4), builder.thing(kChair, 11.6, 9);
  builder.thing(kBed, 1, 4), builder.thing(kChair, 4, 3);
  const Map map = builder.map();
  EXPECT_EQ(placesOf(map, findRegions(map)),
            (std::set<std::set<std::pair<double, double>>>{{{0.5, 0.4}, {6, 0.4}, {11.6, 9}}, {{1, 4}, {4, 3}}}));
}

TEST(Regions, StoreysAreApart) {
  constexpr double kBelow = -kHeight - 0.2;  // m, of the lower storey
  Map map;
  for (const double z : {0.0, kBelow}) {
    Builder builder;
    builder.room(-3, -3, 3, 3, kFloorZ + z);
    builder.thing(kChair, -1, z == 0 ? 1 : 0, kFloorZ + z + 0.5),
        builder.thing(kChair, 1, z == 0 ? 1 : 0, kFloorZ + z + 0.5);
    MapUpdate update;
    update.keyframe = NewKeyframe{};
    update.keyframe->pose.utime_us = 1 + map.keyframes().last();
    update.keyframe->pose.T_map_body.translation().z() = z;
    update.created = builder.all();
    for (MapNode& node : update.created) {
      node.first_us = node.last_us = update.keyframe->pose.utime_us;
    }
    map.apply(std::move(update));
  }
  EXPECT_EQ(placesOf(map, findRegions(map)),
            (std::set<std::set<std::pair<double, double>>>{{{-1, 0}, {1, 0}}, {{-1, 1}, {1, 1}}}));
}

TEST(Regions, TheOrderOfTheNodesDoesNotMatter) {
  const Builder builder = twoRooms();
  const Map map = builder.map();
  const Regions found = findRegions(map);
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Map other = builder.map(seed);
    const Regions again = findRegions(other);
    EXPECT_EQ(placesOf(other, again), placesOf(map, found));
    for (const Region& region : again.regions) {
      EXPECT_TRUE(std::ranges::any_of(found.regions, [&](const Region& r) {
        return (r.belief.mean - region.belief.mean).norm() < 1e-9 && (r.belief.cov - region.belief.cov).norm() < 1e-9;
      }));
    }
  }
}

/// The third level is made as the second: a region's belief is that of all its things' points together.
TEST(Regions, BeliefsAreThoseOfPooledPoints) {
  std::mt19937 random(4);
  std::vector<MapNode> nodes;
  std::vector<Vec3> pooled;
  for (int k = 0; k < 5; ++k) {
    std::vector<Vec3> points;
    const Vec3 middle(1.5 * k, 0.1 * k, 0);
    for (int n = 0; n < 20 + 10 * k; ++n) {
      points.push_back(middle + randomVector(random, 0.4));
    }
    pooled.insert(pooled.end(), points.begin(), points.end());
    nodes.push_back(nodeAt(kCar, middle));
    nodes.back().belief = beliefFromPoints(points);
  }
  const Regions found = findRegions(mapOf(nodes));
  ASSERT_EQ(found.regions.size(), 1U);
  const Belief expected = beliefFromPoints(pooled), &belief = found.regions[0].belief;
  EXPECT_NEAR(belief.kappa, expected.kappa, 1e-9);
  EXPECT_LT((belief.mean - expected.mean).norm(), 1e-9);
  EXPECT_LT((belief.cov - expected.cov).norm(), 1e-9);
  EXPECT_EQ(found.regions[0].objects, (std::vector<NodeId>{1, 2, 3, 4, 5}));
  EXPECT_EQ(found.regions[0].id, 1);
}

TEST(Regions, EdgesAreTheRelativeNeighbourhoodGraphWeighedAsThatOfObjects) {
  std::mt19937 random(5);
  std::vector<MapNode> nodes;
  for (int group = 0; group < 7; ++group) {
    const Vec3 middle(40.0 * (group % 3), 45.0 * (group / 3), 0.3 * group);
    for (int k = 0; k < 3; ++k) {
      nodes.push_back(nodeAt(group % 2 == 0 ? kCar : kPole, middle + randomVector(random, 1)));
    }
  }
  const EdgeModel model{0.01, 0.5};
  const Regions found = findRegions(mapOf(nodes), model);
  ASSERT_EQ(found.regions.size(), 7U);
  std::vector<Vec3> means;
  for (const Region& region : found.regions) {
    means.push_back(region.belief.mean);
  }
  const auto pairs = rngByBruteForce(means);
  ASSERT_EQ(found.edges.size(), pairs.size());
  double largest = 0;
  for (const auto& [i, j] : pairs) {
    largest = std::max(largest, edgeDistance(found.regions[static_cast<std::size_t>(i)].belief,
                                             found.regions[static_cast<std::size_t>(j)].belief, model.sigma_floor));
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto i = static_cast<std::size_t>(pairs[k].first), j = static_cast<std::size_t>(pairs[k].second);
    const double s1 = edgeDistance(found.regions[i].belief, found.regions[j].belief, model.sigma_floor);
    const double s2 = i % 2 == j % 2 ? 0 : 1;
    EXPECT_EQ(found.edges[k].a, found.regions[i].id);
    EXPECT_EQ(found.edges[k].b, found.regions[j].id);
    EXPECT_NEAR(static_cast<double>(found.edges[k].weight), 0.5 * s1 / largest + 0.5 * s2, 1e-6);
  }
}

TEST(Regions, StuffAndCandidatesAreInNone) {
  MapNode candidate = nodeAt(kCar, Vec3(1, 0, 0));
  candidate.classes = {};
  addViews(candidate.classes, {{kWall, 1000.0F}});
  const Regions found =
      findRegions(mapOf({nodeAt(kCar, Vec3::Zero()), candidate, tileNode(kFloor, {}, Vec3(2, 0, 0))}));
  ASSERT_EQ(found.regions.size(), 1U);
  EXPECT_EQ(found.regions[0].objects, std::vector<NodeId>{1});
  EXPECT_TRUE(findRegions(Map{}).regions.empty());
}

TEST(Regions, AreNamedByWhatTheyHold) {
  const Map rooms = twoRooms().map();
  const Regions found = findRegions(rooms);
  ASSERT_EQ(found.regions.size(), 2U);
  EXPECT_EQ(found.regions[0].name, "bedroom");
  EXPECT_EQ(found.regions[1].name, "chairs");
  Builder street;
  for (int k = 0; k < 4; ++k) {
    street.thing(kCar, 2.0 * k, 0);
  }
  const Regions row = findRegions(street.map());
  ASSERT_EQ(row.regions.size(), 1U);
  EXPECT_EQ(row.regions[0].name, "row of cars");
}

// ------------------------------------------------------------------------------------------- in the open

Belief box(double x, double y, double length, double width) {
  return {Vec3(x, y, 0), Vec3(length * length / 12, width * width / 12, 0.1).asDiagonal(), 100};
}

TEST(GroupsInTheOpen, GapsAreBetweenBoxes) {
  EXPECT_NEAR(gapBetween(box(0, 0, 4, 2), box(6, 0, 4, 2)), 2, 1e-12);
  EXPECT_NEAR(gapBetween(box(0, 0, 4, 2), box(0, 6, 4, 2)), 4, 1e-12);
  EXPECT_NEAR(gapBetween(box(0, 0, 4, 2), box(4, 0, 4, 2)), 1, 1e-12);
}

TEST(GroupsInTheOpen, TheTwoSidesOfAStreetAreTwo) {
  std::vector<Belief> cars;
  for (int k = 0; k < 6; ++k) {
    cars.push_back(box(5.7 * k, 0, 4.4, 1.8)), cars.push_back(box(5.7 * k + 2, 8.4, 4.4, 1.8));
  }
  EXPECT_EQ(groupInTheOpen(cars), (std::vector<std::vector<int>>{{0, 2, 4, 6, 8, 10}, {1, 3, 5, 7, 9, 11}}));
}

/// No length is set: what is twice as large and far apart is grouped alike.
TEST(GroupsInTheOpen, LargerThingsFartherApartAreGroupedAlike) {
  std::mt19937 random(6);
  for (int round = 0; round < 20; ++round) {
    std::vector<Belief> things, larger;
    for (int k = 0; k < 30; ++k) {
      const Vec3 p = randomVector(random, 60);
      things.push_back(box(3 * p.x(), 3 * p.y(), 1, 1));
      larger.push_back(box(6 * p.x(), 6 * p.y(), 2, 2));
    }
    bool is_close = false;  // then the least gap counts, which is a length
    for (std::size_t i = 0; i < things.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        is_close = is_close || gapBetween(things[i], things[j]) <= 1;
      }
    }
    EXPECT_TRUE(is_close || groupInTheOpen(things) == groupInTheOpen(larger));
  }
}

}  // namespace
}  // namespace hgg::regions_test
