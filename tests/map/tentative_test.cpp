#include "map/tentative.h"

#include <gtest/gtest.h>

#include "creation/object_graph.h"
#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::tentative_test {
namespace {

const ClassTable& table() {
  static const ClassTable kTable = testClasses();  // poles need five points a frame
  return kTable;
}

/// Frames of a sensor that drives along x, as fuse() and Map::apply() carry them into a map of nothing.
class Drive {
 public:
  explicit Drive(Map map = mapOf({})) : map_(std::move(map)) {}

  /// One frame of these points (map frame), seen from `x`.
  const SmallThings& see(const std::vector<Point>& points, double x, double weight = 1) {
    Frame frame;
    frame.utime_us = ++frames_ * 100'000;
    for (Point p : points) {
      p.x -= static_cast<float>(x);
      frame.points.push_back(p);
    }
    Pose T_map_body = Pose::Identity();
    T_map_body.translation().x() = x;
    RangeImage image(Vec3::Zero());
    for (const Point& p : frame.points) {
      image.add(p.x, p.y, p.z);
    }
    const LocalGraph local = createLocalGraph(frame, T_map_body, table(), {});
    said_ = gatherSmallThings(map_, local, {image, T_map_body}, T_map_body, weight, table(), {});
    grown_ += static_cast<int>(said_.grown.size());
    MapUpdate update;
    update.tentative = said_.tentative;
    map_.apply(std::move(update));
    return said_;
  }

  int grown() const { return grown_; }
  const TentativeThings& tentative() const { return map_.tentative(); }
  Map& map() { return map_; }

 private:
  Map map_;
  SmallThings said_;
  Micros frames_ = 0;
  int grown_ = 0;
};

/// A wall across the way, whose points lie a third of a degree apart from 0, and of which `share` are called pole.
std::vector<Point> wallAt(double x, std::mt19937& random, double share = 0) {
  const double step = 0.006 * x;
  std::vector<Point> points;
  std::uniform_real_distribution<double> dice(0, 1);
  for (double y = -4; y <= 4; y += step) {
    for (double z = -1; z <= 2; z += step) {
      points.push_back(pointAt({x, y, z}, dice(random) < share ? kPole : kRoad));
    }
  }
  return points;
}

/// Two points on a plate of 0.3 m.
void addPlate(std::vector<Point>& points, std::mt19937& random, const Vec3& place, ClassId label = kPole) {
  for (int k = 0; k < 2; ++k) {
    points.push_back(pointAt(place + 0.15 * randomVector(random, 1).cwiseProduct(Vec3(0, 1, 1)), label));
  }
}

TEST(SmallThings, APlateOfTwoPointsAFrameBecomesOneThing) {
  std::mt19937 random(1);
  Drive drive;
  const Vec3 plate(20, 3, 1);
  for (int k = 0; k < 40 && drive.grown() == 0; ++k) {
    std::vector<Point> points = wallAt(30, random);
    addPlate(points, random, plate);
    const SmallThings& said = drive.see(points, 0.2 * k);
    if (!said.grown.empty()) {
      const GrownThing& grown = said.grown[0];
      EXPECT_LT((Vec3(0.2 * k, 0, 0) + grown.object.belief.mean - plate).norm(), 0.15);
      EXPECT_EQ(grown.object.belief.kappa, 2 * grown.frames);
      EXPECT_GE(grown.object.belief.kappa, table().find(kPole)->min_points);
      EXPECT_EQ(grown.object.label, kPole);
    }
  }
  EXPECT_EQ(drive.grown(), 1);
  EXPECT_TRUE(drive.tentative().list.empty());
}

TEST(SmallThings, GrainsOfWrongLabelsOnAWallNeverDo) {
  std::mt19937 random(2);
  Drive drive;
  for (int k = 0; k < 200; ++k) {
    EXPECT_TRUE(drive.see(wallAt(10, random, 0.015), 0.02 * k).grown.empty());
  }
  EXPECT_LT(drive.tentative().list.size(), 100U);  // of some 20,000 grains
}

TEST(SmallThings, GrainsInTheOpenNeverDo) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> across(-4, 4), ahead(5, 25);
  Drive drive;
  for (int k = 0; k < 300; ++k) {
    std::vector<Point> points = wallAt(30, random);
    for (int n = 0; n < 20; ++n) {
      points.push_back(pointAt({ahead(random), across(random), across(random) / 4}, kPole));
    }
    drive.see(points, 0.02 * k);
  }
  EXPECT_EQ(drive.grown(), 0);
}

TEST(SmallThings, WhatIsSeenThroughFades) {
  std::mt19937 random(4);
  Drive drive;
  for (int k = 0; k < 3; ++k) {
    std::vector<Point> points = wallAt(30, random);
    addPlate(points, random, {20, 0, 1});
    drive.see(points, 0.2 * k);
  }
  EXPECT_EQ(drive.tentative().list.size(), 1U);
  for (int k = 3; k < 60; ++k) {
    drive.see(wallAt(30, random), 0.2 * k);
  }
  EXPECT_TRUE(drive.tentative().list.empty());
  EXPECT_GT(drive.tentative().looks_at_noise, 0);
}

TEST(SmallThings, WhatIsHiddenStays) {
  std::mt19937 random(5);
  Drive drive;
  std::vector<Point> points;
  addPlate(points, random, {20, 0, 1});
  drive.see(points, 0);
  ASSERT_EQ(drive.tentative().list.size(), 1U);
  for (int k = 1; k < 60; ++k) {
    drive.see(wallAt(15, random), 0.05 * k);
  }
  EXPECT_EQ(drive.tentative().list.size(), 1U);
}

TEST(SmallThings, ViewsAtRestAreNearlyOneView) {
  std::mt19937 random(6);
  Drive drive;
  for (int k = 0; k < 40; ++k) {
    std::vector<Point> points = wallAt(30, random);
    addPlate(points, random, {20, 3, 1});
    drive.see(points, 0, 0.02);
  }
  EXPECT_EQ(drive.grown(), 0);
}

TEST(SmallThings, AClusterAtANodeOfItsClassBelongsToIt) {
  std::mt19937 random(7);
  MapNode pole = nodeAt(kPole, {20, 3, 1}, 0.1);
  addLeaf(pole, packLeaf({Vec3::Zero(), 0.01 * Mat3::Identity(), 100}));
  MapNode car = nodeAt(kCar, {20, -3, 1}, 0.1);
  addLeaf(car, packLeaf({Vec3::Zero(), 0.01 * Mat3::Identity(), 100}));
  Drive drive(mapOf({pole, car}));
  std::vector<Point> points = wallAt(30, random);
  addPlate(points, random, {20, 3, 1});
  addPlate(points, random, {20, -3, 1});  // a pole where a car is
  drive.see(points, 0);
  ASSERT_EQ(drive.tentative().list.size(), 1U);
  EXPECT_LT(drive.tentative().list[0].belief.mean.y(), 0);
}

TEST(SmallThings, AnObjectOfTheFrameTakesThePlace) {
  std::mt19937 random(8);
  Drive drive;
  for (const int plates : {1, 1, 4}) {
    std::vector<Point> points = wallAt(30, random);
    for (int k = 0; k < plates; ++k) {
      addPlate(points, random, {20, 3, 1});
    }
    drive.see(points, 0);
    EXPECT_EQ(drive.tentative().list.size(), plates == 1 ? 1U : 0U);
  }
  EXPECT_EQ(drive.tentative().looks_at_noise, 0);
}

TEST(SmallThings, TheirNumberIsBounded) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-70, 70);
  Drive drive;
  for (int k = 0; k < 10; ++k) {
    std::vector<Point> points;
    for (int n = 0; n < 1000; ++n) {
      points.push_back(pointAt({place(random), place(random), 0}, kPole));
    }
    drive.see(points, 0);
  }
  EXPECT_GT(drive.tentative().list.size(), 1000U);
  EXPECT_LE(drive.tentative().list.size(), 2048U);
}

TEST(SmallThings, TheyMoveWithTheirKeyframe) {
  std::mt19937 random(10);
  Drive drive;
  std::vector<Point> points = wallAt(30, random);
  addPlate(points, random, {20, 3, 1});
  drive.see(points, 0);
  ASSERT_EQ(drive.tentative().list.size(), 1U);
  const Vec3 before = drive.tentative().list[0].belief.mean;
  MapCorrection correction;
  correction.moved.emplace_back(0, Pose(Eigen::Translation3d(1, 2, 3)));
  drive.map().apply(correction);
  EXPECT_NEAR((drive.tentative().list[0].belief.mean - before - Vec3(1, 2, 3)).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace hgg::tentative_test
