#include "map/fuse.h"

#include <gtest/gtest.h>

#include "creation/geometry_graph.h"
#include "creation/instances.h"
#include "map/class_evidence.h"
#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::fuse_test {
namespace {

/// A frame's graph of these objects, one a frame of map points, seen from T_map_body.
LocalGraph seenFrom(const Pose& T_map_body, const std::vector<Frame>& objects_map) {
  const Config config;
  LocalGraph local;
  for (const Frame& points_map : objects_map) {
    std::vector<PackedPoint> points;
    std::vector<Vec3> wide;
    for (const Point& p : points_map.points) {
      const Point body = pointAt(T_map_body.inverse() * Vec3(p.x, p.y, p.z), p.label);
      points.emplace_back(body.x, body.y, body.z, 0.0F);
      wide.emplace_back(body.x, body.y, body.z);
    }
    LocalObject object;
    object.label = points_map.points[0].label;
    object.belief = beliefFromPoints(wide);
    object.T_body_object = objectFrame(object.belief);
    object.stuff = object.label == kRoad;
    object.tile = object.stuff ? tileOf(T_map_body * object.belief.mean, config.creation.tile_size) : Tile{};
    object.leaves = partitionLeaves(points, object.T_body_object, config.creation.leaf_points, {1.0F, 0});
    local.objects.push_back(std::move(object));
  }
  return local;
}

/// Pairs every stuff object with the node of its tile.
std::vector<ObjectPair> pairsByTile(const Map& map, const LocalGraph& local) {
  std::vector<ObjectPair> pairs;
  for (std::size_t i = 0; i < local.objects.size(); ++i) {
    const LocalObject& object = local.objects[i];
    const MapNode* node = object.stuff ? map.findTile(object.label, object.tile) : nullptr;
    if (node != nullptr) {
      pairs.push_back({static_cast<int>(i), node->id, 0});
    }
  }
  return pairs;
}

/// Applies the fusion of a frame to the map.
MapDelta fuseInto(Map& map, const LocalGraph& local, const Pose& T, const std::vector<ObjectPair>& pairs = {}) {
  const Config config;
  const auto evidence = classEvidence(local, map, T, 1, config.map.active_radius, config.creation.sigma_floor);
  MapUpdate update = fuse(map, local, T, pairs, evidence, testClasses(), config);
  update.keyframe = keyframeIfNeeded(map, {local.utime_us, T});
  return map.apply(std::move(update));
}

/// The same for a frame whose one object is node 1, once that exists.
void fuseIntoFirst(Map& map, const LocalGraph& local, const Pose& T) {
  fuseInto(map, local, T, map.nodes().empty() ? std::vector<ObjectPair>{} : std::vector<ObjectPair>{{0, 1, 0}});
}

double kappaOf(const Map& map) {
  double sum = 0;
  for (const auto& [id, node] : map.nodes()) {
    sum += node.belief.kappa;
  }
  return sum;
}

double leafKappaOf(const MapNode& node) {
  double sum = 0;
  for (const Leaf& leaf : leavesOf(node)) {
    sum += leaf.kappa;
  }
  return sum;
}

double kappaOf(const LocalGraph& local) {
  double sum = 0;
  for (const LocalObject& object : local.objects) {
    sum += object.belief.kappa;
  }
  return sum;
}

Pose viewpoint(double x, double yaw_deg) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(x, -8, 1);
  return T;
}

Frame box(std::mt19937& random, int points, ClassId label, const Vec3& centre, const Vec3& half) {
  Frame frame;
  addBox(frame, random, points, label, centre, half);
  return frame;
}

Frame carAt(std::mt19937& random, const Vec3& centre, int points) {
  return box(random, points, kCar, centre, Vec3(2.1, 0.9, 0.7));
}

Frame together(Frame a, const Frame& b) {
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  return a;
}

void expectPooled(const Belief& actual, const Frame& frame_map) {
  std::vector<Vec3> points;
  for (const Point& p : frame_map.points) {
    points.emplace_back(p.x, p.y, p.z);
  }
  const Belief expected = beliefFromPoints(points);
  EXPECT_LE((actual.mean - expected.mean).norm(), 1e-5);  // the points went through floats of another frame
  EXPECT_LE((actual.cov - expected.cov).norm(), 1e-5);
  EXPECT_EQ(actual.kappa, expected.kappa);
}

TEST(Fuse, UnmatchedObjectsBecomeNodesWithTheirCounts) {
  std::mt19937 random(1);
  const Pose T = viewpoint(3, 40);
  const Frame car = carAt(random, Vec3(4, 2, 0), 700);
  const Frame pole = box(random, 321, kPole, Vec3(12, 3, 1), Vec3(0.1, 0.1, 1.5));
  LocalGraph local = seenFrom(T, {car, pole});
  local.utime_us = 777;
  Map map;
  EXPECT_EQ(fuseInto(map, local, T).changed, (std::vector<NodeId>{1, 2}));
  EXPECT_EQ(map.find(1)->label, kCar);
  EXPECT_EQ(map.find(2)->label, kPole);
  expectPooled(map.find(1)->belief, car);
  expectPooled(map.find(2)->belief, pole);
  for (const NodeId id : {1, 2}) {
    const MapNode& node = *map.find(id);
    EXPECT_EQ(leafKappaOf(node), node.belief.kappa);
    EXPECT_EQ(node.views, 1);
    EXPECT_EQ(node.first_us, 777);
    EXPECT_EQ(node.last_us, 777);
    EXPECT_LE((node.T_map_object.translation() - node.belief.mean).norm(), 1e-9);
  }
  EXPECT_EQ(map.keyframes().poses().back().utime_us, 777);
  EXPECT_EQ(map.keyframes().poses().back().T_map_body.matrix(), T.matrix());
}

TEST(Fuse, MatchedObjectsMergeAsIfTheirPointsWerePooled) {
  std::mt19937 random(2);
  Frame all;
  Map map;
  for (int view = 0; view < 5; ++view) {
    const Pose T = viewpoint(2.0 * view, 20.0 * view);
    const Frame seen = carAt(random, Vec3(5, 3, 0), 200 + 100 * view);
    LocalGraph local = seenFrom(T, {seen});
    local.utime_us = 100 * view;
    fuseIntoFirst(map, local, T);
    all = together(all, seen);
    ASSERT_EQ(map.nodes().size(), 1U);
    const MapNode& node = *map.find(1);
    expectPooled(node.belief, all);
    EXPECT_EQ(leafKappaOf(node), node.belief.kappa);
    EXPECT_EQ(node.views, view + 1);
    EXPECT_EQ(node.first_us, 0);
    EXPECT_EQ(node.last_us, 100 * view);
  }
}

TEST(Fuse, LeavesMergeIntoTheirNodesBelief) {
  std::mt19937 random(3);
  Map map;
  for (int view = 0; view < 5; ++view) {
    const Pose T = viewpoint(view, 15.0 * view);
    fuseIntoFirst(map, seenFrom(T, {carAt(random, Vec3(5, 3, 0), 900)}), T);
  }
  const MapNode& node = *map.find(1);
  Belief merged;
  for (const Leaf& leaf : leavesOf(node)) {
    merged = merge(merged, transform(node.T_map_object, unpackLeaf(leaf)));
  }
  EXPECT_LE((merged.mean - node.belief.mean).norm(), 1e-5);
  EXPECT_LE((merged.cov - node.belief.cov).norm(), 1e-5);
  EXPECT_EQ(merged.kappa, node.belief.kappa);
}

TEST(Fuse, AFragmentInsideAnObjectMergesIntoIt) {
  std::mt19937 random(4);
  const Pose T = viewpoint(0, 0);
  // The segmenter gave the middle of a car another id.
  const Frame car = carAt(random, Vec3(5, 3, 0), 900),
              piece = box(random, 60, kCar, Vec3(5.2, 3.1, 0), Vec3(0.3, 0.3, 0.3));
  const LocalGraph split = seenFrom(T, {car, piece});
  Map map;
  fuseInto(map, split, T);
  ASSERT_EQ(map.nodes().size(), 1U);
  EXPECT_EQ(kappaOf(map), 960);
  EXPECT_EQ(leafKappaOf(map.nodes().begin()->second), 960);

  // And again as an unmatched piece of a later frame: the node in the map stays, with its id.
  const MapDelta delta = fuseInto(map, split, T, {{0, 1, 0}});
  EXPECT_EQ(delta.changed, (std::vector<NodeId>{1}));
  EXPECT_TRUE(delta.removed.empty());
  EXPECT_EQ(kappaOf(map), 1920);
}

TEST(Fuse, TwoHalvesOfACarSeenAsTwoMergeOnceTheyOverlap) {
  std::mt19937 random(5);
  const Pose T = viewpoint(0, 0);
  const Frame front = box(random, 500, kCar, Vec3(6.4, 3, 0), Vec3(1.2, 0.9, 0.7));
  const Frame back = box(random, 500, kCar, Vec3(5.0, 3, 0), Vec3(1.6, 0.9, 0.7));
  Map map;
  fuseInto(map, seenFrom(T, {front, back}), T);
  ASSERT_EQ(map.nodes().size(), 1U);
  expectPooled(map.find(1)->belief, together(front, back));
}

TEST(Fuse, ABridgeBetweenTwoNodesLeavesTheOlderOneAndReportsTheOther) {
  std::mt19937 random(6);
  const Pose T = viewpoint(0, 0);
  const Frame left = box(random, 400, kCar, Vec3(4, 3, 0), Vec3(0.8, 0.9, 0.7));
  const Frame right = box(random, 400, kCar, Vec3(6.4, 3, 0), Vec3(0.8, 0.9, 0.7));
  const Frame whole = box(random, 900, kCar, Vec3(5.2, 3, 0), Vec3(2.0, 0.9, 0.7));
  Map map;
  fuseInto(map, seenFrom(T, {left}), T);
  fuseInto(map, seenFrom(T, {right}), T);
  ASSERT_EQ(map.nodes().size(), 2U);
  const MapDelta delta = fuseInto(map, seenFrom(T, {whole}), T, {{0, 2, 0.5}});
  EXPECT_EQ(delta.changed, (std::vector<NodeId>{1}));
  EXPECT_EQ(delta.removed, (std::vector<NodeId>{2}));
  ASSERT_EQ(map.nodes().size(), 1U);
  expectPooled(map.find(1)->belief, together(together(left, right), whole));
}

TEST(Fuse, NeighboursFartherApartThanTheirClassClustersStayApart) {
  // Parked side by side with 1.4 m of air, more than twice the radius of their class; one may be seen hardly at all.
  std::mt19937 random(7);
  for (const int points : {900, 400, 60, 20}) {
    Map map;
    for (int view = 0; view < 10; ++view) {
      const Pose T = viewpoint(view, 5.0 * view);
      const LocalGraph local = seenFrom(T, {carAt(random, Vec3(5, 3, 0), 900), carAt(random, Vec3(5, 6.2, 0), points)});
      fuseInto(map, local, T, view == 0 ? std::vector<ObjectPair>{} : std::vector<ObjectPair>{{0, 1, 0}, {1, 2, 0}});
      ASSERT_EQ(map.nodes().size(), 2U) << points << " points, view " << view;
    }
  }
}

TEST(Fuse, ObjectsOfDifferentClassesNeverMerge) {
  std::mt19937 random(8);
  const Pose T = viewpoint(0, 0);
  const Frame pole = box(random, 300, kPole, Vec3(5, 3, 0), Vec3(0.1, 0.1, 0.7));
  Map map;
  fuseInto(map, seenFrom(T, {carAt(random, Vec3(5, 3, 0), 900), pole}), T);
  EXPECT_EQ(map.nodes().size(), 2U);
}

TEST(Fuse, StuffMergesWithinItsTileAndNeverAcross) {
  std::mt19937 random(9);
  Map map;
  for (int view = 0; view < 3; ++view) {
    const Pose T = viewpoint(view, 10.0 * view);
    const Frame left = box(random, 2000, kRoad, Vec3(3, 0, -1), Vec3(1.9, 4.9, 0.02));
    const Frame right = box(random, 2000, kRoad, Vec3(7, 0, -1), Vec3(1.9, 4.9, 0.02));  // across the border, x = 5
    const LocalGraph local = seenFrom(T, {left, right});
    fuseInto(map, local, T, pairsByTile(map, local));
  }
  ASSERT_EQ(map.nodes().size(), 2U);
  for (const auto& [id, node] : map.nodes()) {
    EXPECT_TRUE(node.stuff);
    EXPECT_EQ(map.findTile(kRoad, node.tile), &node);
    EXPECT_EQ(node.belief.kappa, 6000);
  }
}

TEST(Fuse, ConservesTheEvidenceExactlyWhateverTheFramesAndPairs) {
  std::mt19937 random(10);
  for (int round = 0; round < 5; ++round) {
    Map map;
    double total = 0;
    for (int step = 0; step < 20; ++step) {
      const Pose T = randomPose(random, 5);
      std::vector<Frame> objects{box(random, 300, kRoad, Vec3(0, 0, -1), Vec3(4, 4, 0.01))};
      for (int k = 0; k < 12; ++k) {  // colliding, so that much overlaps
        const int points = 10 + static_cast<int>(below(random, 200));
        objects.push_back(box(random, points, kCar, randomVector(random, 8), randomVector(random, 1.5)));
      }
      const LocalGraph local = seenFrom(T, objects);
      std::vector<ObjectPair> pairs = pairsByTile(map, local);
      int next = 1;
      for (const auto& [id, node] : map.nodes()) {
        if (!node.stuff && next <= 12 && below(random, 2) == 0) {
          pairs.push_back({next++, id, 0});  // any pair will do
        }
      }
      total += kappaOf(local);
      fuseInto(map, local, T, pairs);
      ASSERT_EQ(kappaOf(map), total) << "round " << round << ", step " << step;
      for (const auto& [id, node] : map.nodes()) {
        ASSERT_EQ(leafKappaOf(node), node.belief.kappa);
      }
    }
  }
}

TEST(Fuse, LeafCountIsBoundedBySurfaceNotByViews) {
  // A wall of 8 m by 3 m, seen a thousand times with a jitter of the pose, differently sampled each time.
  std::mt19937 random(11);
  const double cells = 8 * 3 / std::pow(Config{}.map.leaf_size, 2);
  Map map;
  std::size_t early = 0;
  for (int view = 0; view < 1000; ++view) {
    const Pose T = viewpoint(uniform(random, 0, 8), uniform(random, -30, 30));
    const Frame wall = box(random, 1500, kPole, Vec3(4, 4, 1.5) + randomVector(random, 0.02), Vec3(4, 0.02, 1.5));
    fuseIntoFirst(map, seenFrom(T, {wall}), T);
    early = view == 100 ? map.leafCount() : early;
  }
  ASSERT_EQ(map.nodes().size(), 1U);
  EXPECT_LE(static_cast<double>(map.leafCount()), 2 * cells);
  EXPECT_LE(static_cast<double>(map.leafCount()), 1.2 * static_cast<double>(early))
      << "still growing after a hundred views";
  EXPECT_EQ(kappaOf(map), 1.5e6);
  const MapNode& node = *map.find(1);
  for (const Leaf& leaf : leavesOf(node)) {
    EXPECT_NEAR((node.T_map_object * unpackLeaf(leaf).mean).y(), 4, 0.1) << "a leaf left the wall";
  }
}

TEST(Fuse, OfAnEmptyFrameOnlyMovesThePose) {
  std::mt19937 random(12);
  Map map;
  fuseInto(map, seenFrom(viewpoint(0, 0), {carAt(random, Vec3(5, 3, 0), 500)}), viewpoint(0, 0));
  LocalGraph nothing;
  nothing.utime_us = 9;
  const MapDelta delta = fuseInto(map, nothing, viewpoint(5, 0));
  EXPECT_TRUE(delta.changed.empty());
  EXPECT_TRUE(delta.removed.empty());
  EXPECT_EQ(map.keyframes().poses().size(), 2U);
  EXPECT_EQ(map.nodes().size(), 1U);
}

/// A frame's cloud of a block 2 x 1 x 1 m at x metres, called `label`.
Frame block(ClassId label, double x, int n = 500) {
  std::mt19937 random(21);
  Frame frame;
  addBox(frame, random, n, label, Vec3(x, 0, 0), Vec3(1, 0.5, 0.5));
  return frame;
}

/// A map that has seen these blocks, one a frame, nothing being paired beforehand.
Map mapOfFrames(const std::vector<Frame>& frames) {
  Map map;
  for (const Frame& frame : frames) {
    fuseInto(map, seenFrom(Pose::Identity(), {frame}), Pose::Identity());
  }
  return map;
}

TEST(Believe, AThingCalledSomethingElseForAWhileStaysOneThing) {
  const Map map = mapOfFrames({block(kCar, 5), block(kCar, 5), block(kPole, 5), block(kCar, 5)});
  ASSERT_EQ(map.nodes().size(), 1U);
  const MapNode& node = map.nodes().begin()->second;
  EXPECT_EQ(node.label, kCar);
  EXPECT_EQ(node.belief.kappa, 2000);
  EXPECT_NEAR(weightOf(classProbabilities(node.classes), kCar), 0.75, 0.03);
}

TEST(Believe, AFirstViewThatWasWrongIsOutvoted) {
  Map map = mapOfFrames({block(kPole, 5)});
  EXPECT_EQ(map.find(1)->label, kPole);
  for (int k = 0; k < 3; ++k) {
    fuseInto(map, seenFrom(Pose::Identity(), {block(kCar, 5)}), Pose::Identity());
  }
  ASSERT_EQ(map.nodes().size(), 1U);
  EXPECT_EQ(map.nodes().begin()->second.label, kCar);
  EXPECT_EQ(map.nodes().begin()->second.belief.kappa, 2000);
}

TEST(Believe, AThingThatTurnsOutToBeStuffFadesAndGoes) {
  Map map = mapOfFrames({block(kCar, 5, 50)});
  EXPECT_FALSE(isConfirmed(*map.find(1))) << "50 points, seen once";
  int frames = 0;
  while (map.find(1) != nullptr && frames < 100) {
    fuseInto(map, seenFrom(Pose::Identity(), {block(kRoad, 5)}), Pose::Identity());
    ++frames;
  }
  EXPECT_GT(frames, 5) << "one view is no proof";
  EXPECT_LT(frames, 100);
}

TEST(Believe, AThingWhoseClassLeftTheTableIsKept) {
  constexpr ClassId kGone = 99;
  MapNode thing = nodeAt(kGone, Vec3(5, 0, 0));
  addLeaf(thing, packLeaf({Vec3::Zero(), 0.25 * Mat3::Identity(), 100}));
  Map map = mapOf({thing});
  fuseInto(map, seenFrom(Pose::Identity(), {block(kCar, 6.5)}), Pose::Identity());
  ASSERT_NE(map.find(1), nullptr);
  EXPECT_EQ(map.find(1)->label, kGone);
}

/// A thin plate 0.6 x 0.4 m, called `label`, `proud` of the plane x = 5.
Frame plate(ClassId label, double proud, const Vec3& half, int n) {
  std::mt19937 random(22);
  Frame frame;
  addBox(frame, random, n, label, Vec3(5 - proud, 0, 0), half);
  return frame;
}

TEST(Believe, ASignOnADoorIsThereEvenIfItsFirstViewWasTakenForDoor) {
  const Frame door = plate(kCar, 0, Vec3(0.02, 0.6, 1), 800);
  const Frame sign = plate(kPole, 0.05, Vec3(0.01, 0.3, 0.2), 300);
  Frame mistaken = door;
  for (Point p : sign.points) {
    p.label = kCar;
    mistaken.points.push_back(p);
  }
  Map map;
  fuseInto(map, seenFrom(Pose::Identity(), {mistaken}), Pose::Identity());
  for (int k = 0; k < 20; ++k) {
    std::vector<ObjectPair> pairs{{0, 1, 0}};
    if (map.find(2) != nullptr) {
      pairs.push_back({1, 2, 0});
    }
    fuseInto(map, seenFrom(Pose::Identity(), {door, sign}), Pose::Identity(), pairs);
  }
  ASSERT_EQ(map.nodes().size(), 2U);
  EXPECT_EQ(map.find(1)->label, kCar);
  EXPECT_EQ(map.find(2)->label, kPole);
  EXPECT_TRUE(isConfirmed(*map.find(2)));
}

TEST(Believe, PiecesOfAFrameAreOneView) {
  const Frame whole = block(kCar, 5);
  Frame left, right;
  for (const Point& p : whole.points) {
    (p.x < 5 ? left : right).points.push_back(p);
  }
  Map map = mapOfFrames({whole});
  for (int k = 0; k < 10; ++k) {
    fuseInto(map, seenFrom(Pose::Identity(), {left, right}), Pose::Identity(), {{0, 1, 0}});
  }
  ASSERT_EQ(map.nodes().size(), 1U);
  EXPECT_LE(sumOf(map.find(1)->classes.views), 11);
}

TEST(Believe, EvidenceOfAThingThatAFrameMergesAwayIsNoFault) {
  Map map = mapOf({nodeAt(kCar, Vec3(5, 0, 0)), nodeAt(kCar, Vec3(5.1, 0, 0))});
  for (NodeId id : {1, 2}) {
    MapUpdate update;
    update.changed.push_back(*map.find(id));
    addLeaf(update.changed[0], packLeaf({Vec3::Zero(), 0.25 * Mat3::Identity(), 100}));
    map.apply(std::move(update));
  }
  const LocalGraph local = seenFrom(Pose::Identity(), {block(kCar, 5)});
  fuseInto(map, local, Pose::Identity(), {{0, 1, 0}});
  EXPECT_EQ(map.nodes().size(), 1U);
}

TEST(Believe, WhatAFrameHasAtThePlaceOfAThingIsCountedThoughTheThingIsNotSeen) {
  Map map = mapOfFrames({block(kCar, 5)});
  const double before = sumOf(map.find(1)->classes.views);
  const MapDelta delta = fuseInto(map, seenFrom(Pose::Identity(), {block(kRoad, 5)}), Pose::Identity());
  EXPECT_NEAR(sumOf(map.find(1)->classes.views), before + 1, 0.1);
  EXPECT_EQ(map.find(1)->views, 1);
  EXPECT_EQ(delta.changed, (std::vector<NodeId>{1, 2})) << "subscribers hear of it";
}

TEST(Absorb, AddsEvidenceLeavesAndTimeAndKeepsTheFrame) {
  std::mt19937 random(14);
  MapNode keep = nodeAt(kCar, Vec3(0, 0, 0)), other = nodeAt(kCar, Vec3(1, 0, 0), 0.5, 40);
  keep.id = 3, other.id = 9;
  keep.views = 4, other.views = 6, keep.first_us = 50, keep.last_us = 60, other.first_us = 10, other.last_us = 55;
  addLeaf(keep, packLeaf({Vec3(0, 0, 0), 1e-4 * Mat3::Identity(), 100}));
  other.T_map_object.linear() = randomRotation(random);
  addLeaf(other, packLeaf({Vec3(0, 0, 0), 1e-4 * Mat3::Identity(), 40}));
  const Pose frame = keep.T_map_object;
  absorb(keep, other, 0.4);
  EXPECT_EQ(keep.id, 3);
  EXPECT_EQ(keep.T_map_object.matrix(), frame.matrix());
  EXPECT_EQ(keep.belief.kappa, 140);
  EXPECT_NEAR(keep.belief.mean.x(), 40.0 / 140, 1e-12);
  EXPECT_EQ(keep.views, 6);
  EXPECT_EQ(weightOf(keep.classes.views, kCar), 1000) << "two thousand views, faded to the most there can be";
  EXPECT_EQ(keep.first_us, 10);
  EXPECT_EQ(keep.last_us, 60);
  const Leaves& leaves = leavesOf(keep);
  ASSERT_EQ(leaves.size(), 2U);
  EXPECT_NEAR(leaves[0].mean[0] + leaves[1].mean[0], 1, 1e-6);  // a metre apart in the frame of the one kept
}

}  // namespace
}  // namespace hgg::fuse_test
