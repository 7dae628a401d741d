#include "map/class_evidence.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::class_evidence_test {
namespace {

/// A frame's object of these leaves, the body frame being the map's.
LocalObject objectOf(ClassId label, const std::vector<Belief>& leaves) {
  LocalObject object;
  object.label = label;
  object.belief = leaves[0];
  for (const Belief& leaf : leaves) {
    object.leaves.push_back(leaf);
    object.belief = &leaf == &leaves[0] ? leaf : merge(object.belief, leaf);
  }
  return object;
}

Belief ball(const Vec3& mean, double deviation, double kappa) {
  return {mean, deviation * deviation * Mat3::Identity(), kappa};
}

/// A map of one thing with these leaves, id 1.
Map mapWith(ClassId label, const std::vector<Belief>& leaves) {
  MapNode node = nodeAt(label, leaves[0].mean);
  node.T_map_object = Pose::Identity();
  node.belief = leaves[0];
  for (const Belief& leaf : leaves) {
    node.belief = &leaf == &leaves[0] ? leaf : merge(node.belief, leaf);
    addLeaf(node, packLeaf(leaf));
  }
  return mapOf({node});
}

std::vector<ClassEvidence> evidenceOf(const Map& map, std::vector<LocalObject> objects, double weight = 1) {
  LocalGraph local;
  local.objects = std::move(objects);
  return classEvidence(local, map, Pose::Identity(), weight, 100, 0.01);
}

/// As a map keeps it.
Belief precisely(const Belief& leaf) { return unpackLeaf(packLeaf(leaf)); }

double shareOf(const std::vector<ClassEvidence>& evidence, ClassId label) {
  return weightOf(evidence.at(0).view.labels, label) / sumOf(evidence.at(0).view.labels);
}

TEST(ShareOn, IsTheIntegralOfThePointsOverTheSoftWindow) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int scene = 0; scene < 5; ++scene) {
    const Belief window = precisely(randomBelief(random, 1)), leaf = randomBelief(random, 1);
    const Map map = mapWith(kCar, {window});
    const Mat3 root = leaf.cov.llt().matrixL(), inverse = window.cov.inverse();
    double inside = 0;
    constexpr int kSamples = 200'000;
    for (int k = 0; k < kSamples; ++k) {
      const Vec3 d = leaf.mean + root * Vec3(normal(random), normal(random), normal(random)) - window.mean;
      inside += std::exp(-0.5 * d.dot(inverse * d)) / kSamples;
    }
    EXPECT_NEAR(shareOn(*map.find(1), objectOf(kCar, {leaf}), Pose::Identity(), 0),
                std::min(inside / std::sqrt(0.125), 1.0), 0.02)
        << scene;
  }
}

TEST(ShareOn, IsNeverMoreThanAllAndNothingFarAway) {
  const Belief leaf = ball(Vec3(3, 0, 0), 0.2, 50);
  const Map map = mapWith(kCar, std::vector<Belief>(10, leaf));
  EXPECT_EQ(shareOn(*map.find(1), objectOf(kCar, {leaf}), Pose::Identity(), 0.01), 1);
  EXPECT_EQ(shareOn(*map.find(1), objectOf(kCar, {ball(Vec3(9, 0, 0), 0.2, 50)}), Pose::Identity(), 0.01), 0);
}

TEST(ClassEvidence, AThingSeenAgainIsEvidenceForItself) {
  const Belief leaf = ball(Vec3(3, 0, 0), 0.2, 200);
  const auto evidence = evidenceOf(mapWith(kCar, {leaf}), {objectOf(kCar, {leaf})});
  ASSERT_EQ(evidence.size(), 1U);
  EXPECT_EQ(evidence[0].id, 1);
  EXPECT_GT(weightOf(evidence[0].view.labels, kCar), 0.9);
  EXPECT_LT(weightOf(evidence[0].view.labels, kCar), 1);
  EXPECT_EQ(evidence[0].view.labels.size(), 1U);
}

TEST(ClassEvidence, ASliverOnAnotherSurfaceIsThatSurface) {
  const Map map = mapWith(kCar, {ball(Vec3(3, 0, 0), 0.1, 20)});
  Belief surface = ball(Vec3(3, 0.2, 0), 0.5, 2000);
  surface.cov(0, 0) = 1e-4;
  EXPECT_EQ(shareOf(evidenceOf(map, {objectOf(kPole, {surface})}), kPole), 1);
}

TEST(ClassEvidence, WhatReachesOverFromANeighbourDoesNotCount) {
  const Belief own = ball(Vec3(3, 0, 0), 0.3, 300), beside = ball(Vec3(3, 0.9, 0), 0.3, 300);
  EXPECT_EQ(shareOf(evidenceOf(mapWith(kCar, {own}), {objectOf(kCar, {own}), objectOf(kPole, {beside})}), kCar), 1);
}

TEST(ClassEvidence, APieceOfAThingIsAPartOfAView) {
  const Belief left = ball(Vec3(3, 0, 0), 0.2, 500), right = ball(Vec3(3, 4, 0), 0.2, 500);
  const auto evidence = evidenceOf(mapWith(kCar, {left, right}), {objectOf(kPole, {right})});
  EXPECT_NEAR(weightOf(evidence.at(0).view.labels, kPole), 0.5, 0.01) << "the other half was not looked at";
}

TEST(ClassEvidence, ViewsFromOnePlaceAreOneView) {
  Pose step = Pose::Identity();
  const double rest = viewWeight(step);
  EXPECT_GT(rest, 0);
  EXPECT_LT(rest, 0.05);
  step.translation().x() = 0.1;
  EXPECT_EQ(viewWeight(step), 1);
  step = Pose(Eigen::AngleAxisd(0.1, Vec3::UnitZ()));
  EXPECT_EQ(viewWeight(step), 1);
  const Belief leaf = ball(Vec3(3, 0, 0), 0.2, 200);
  const Map map = mapWith(kCar, {leaf});
  EXPECT_NEAR(sumOf(evidenceOf(map, {objectOf(kCar, {leaf})}, rest)[0].view.labels),
              rest * sumOf(evidenceOf(map, {objectOf(kCar, {leaf})})[0].view.labels), 1e-6);
}

TEST(ClassEvidence, ThingsWithoutPointsAndStuffHaveNone) {
  Map map = mapWith(kCar, {ball(Vec3(30, 0, 0), 0.2, 50)});
  MapUpdate update;
  update.created.push_back(tileNode(kRoad, {0, 0, 0}, Vec3(3, 0, 0)));
  addLeaf(update.created[0], packLeaf(ball(Vec3::Zero(), 0.5, 100)));
  map.apply(std::move(update));
  EXPECT_TRUE(evidenceOf(map, {objectOf(kRoad, {ball(Vec3(3, 0, 0), 0.5, 100)})}).empty());
  EXPECT_TRUE(evidenceOf(map, {}).empty());
}

/// What a sensor at the origin sees through that has walls (m along x) of these slopes' widths before it.
FreeSpace spaceBehind(double wall, double screen = 0) {
  FreeSpace free{RangeImage(Vec3::Zero()), Pose::Identity()};
  for (int row = -60; row <= 60; ++row) {
    for (int column = -60; column <= 60; ++column) {
      const auto depth = static_cast<float>(screen > 0 ? screen : wall);
      const auto slope = [&](int k) { return depth * 0.005F * static_cast<float>(k); };
      free.image.add(depth, slope(column), slope(row));
    }
  }
  return free;
}

TEST(ViewsAsStuff, AreTheTimesTheWallHasAsManyPointsThere) {
  const std::vector<Belief> patch{ball({5, 0, 1}, 0.1, 30), ball({5, 0.5, 1}, 0.1, 30)};
  MapNode wall = nodeAt(kRoad, {5, 0, 1});
  wall.stuff = true, wall.views = 40;
  wall.T_map_object = Pose::Identity();
  wall.belief = ball({5, 0.25, 1}, 0.3, 600);
  for (Belief leaf : patch) {
    leaf.kappa = 300;  // ten frames' worth
    addLeaf(wall, packLeaf(leaf));
  }
  const auto viewsOn = [&](std::int32_t views) {
    wall.views = views;
    return viewsAsStuff(mapOf({wall}), objectOf(kCar, patch), Pose::Identity(), 0.001);
  };
  EXPECT_NEAR(weightOf(viewsOn(40), kRoad), 10, 0.5);
  EXPECT_NEAR(weightOf(viewsOn(4), kRoad), 4, 1e-6) << "no more than it was seen";
  EXPECT_TRUE(viewsAsStuff(mapOf({wall}), objectOf(kCar, {ball({5, 3, 1}, 0.1, 30)}), Pose::Identity(), 0.001).empty());
}

TEST(FreeSpace, AThingTakenAwayIsSeenThroughAndAHiddenOneNever) {
  const Map map = mapWith(kCar, {ball(Vec3(10, 0, 0), 0.2, 500), ball(Vec3(10, 1, 0), 0.2, 500)});
  const auto through = [&](const FreeSpace& free) {
    const auto evidence = classEvidence({}, map, Pose::Identity(), 1, 100, 0.01, &free);
    return evidence.empty() ? 0 : evidence[0].view.through;
  };
  EXPECT_GT(through(spaceBehind(20)), 0.7);
  EXPECT_EQ(through(spaceBehind(20, 5)), 0) << "behind a nearer one";
  EXPECT_EQ(through(spaceBehind(10)), 0) << "there";
  FreeSpace aside = spaceBehind(20);
  aside.T_map_sensor = Pose(Eigen::AngleAxisd(2, Vec3::UnitZ()));
  EXPECT_EQ(through(aside), 0) << "out of view";
}

TEST(FreeSpace, AThingThatTheFrameHasIsFoundWhereverItsPointsAre) {
  const Map map = mapWith(kCar, {ball(Vec3(10, 0, 0), 0.2, 500)});
  FreeSpace free = spaceBehind(20);
  free.found = {1};
  EXPECT_EQ(classEvidence({}, map, Pose::Identity(), 0.5, 100, 0.01, &free).at(0).view.is_found, 0.5);
}

}  // namespace
}  // namespace hgg::class_evidence_test
