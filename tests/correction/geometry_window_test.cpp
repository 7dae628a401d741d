#include "correction/geometry_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>

#include "map/test_map.h"

namespace hgg::geometry_window_test {
namespace {

constexpr ClassId kWall = 50;
constexpr double kBlur = 0.15;        // m, of bad leaves about the surface
constexpr double kSigmaFloor = 0.01;  // m
constexpr int kMaxPoints = 8000;      // of a keyframe

Pose poseOf(int k) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(0.1 * k, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(2 * k, -6, 1);
  return T;
}

KeyframeGraph keyframes(int count) {
  KeyframeGraph graph;
  for (int k = 0; k < count; ++k) {
    graph.add({1000 * k, poseOf(k)});
  }
  return graph;
}

/// The corner of a house: two walls, y = 0 and x = 0, in its own frame.
Vec3 onCorner(std::mt19937& random) {
  const double along = uniform(random, 0, 4), up = uniform(random, 0, 2);
  return below(random, 2) == 0 ? Vec3(along, 0, up) : Vec3(0, along, up);
}

/// A corner whose leaves lie beside its walls, and are thick.
MapNode corner(NodeId id, std::mt19937& random, double kappa = 100) {
  MapNode node;
  node.id = id;
  node.label = kWall;
  node.stuff = true;
  node.anchor = 0;
  node.views = 7;
  node.belief = randomBelief(random, 10);
  node.T_map_object = randomPose(random, 10);
  for (int n = 0; n < 24; ++n) {
    addLeaf(node, packLeaf({onCorner(random) + randomVector(random, kBlur),
                            Vec3(0.25, 0.25, 0.25).asDiagonal() * kBlur * kBlur * 4, kappa}));
  }
  return node;
}

/// What a keyframe sees of nodes: `count` points of each.
struct Seen {
  LocalGraph local;
  std::vector<ObjectPair> pairs;

  void add(const MapNode& node, const Pose& T_map_body, int count, std::mt19937& random) {
    LocalObject object;
    object.label = node.label;
    object.stuff = node.stuff;
    object.begin = local.points.size();
    for (int n = 0; n < count; ++n) {
      PackedPoint point = PackedPoint::Zero();
      point.head<3>() = (T_map_body.inverse() * node.T_map_object * onCorner(random)).cast<float>().array();
      local.points.push_back(point);
    }
    object.end = local.points.size();
    pairs.push_back({static_cast<int>(local.objects.size()), node.id, 0});
    local.objects.push_back(object);
  }
};

Seen seenFrom(const Map& map, int k, int count, std::mt19937& random) {
  Seen seen;
  for (const auto& [id, node] : map.nodes()) {
    seen.add(node, map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body, count, random);
  }
  return seen;
}

bool sameLeaves(const std::vector<Leaf>& a, const std::vector<Leaf>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Leaf)) == 0);
}

double evidenceOf(const MapNode& node) {
  double sum = 0;
  for (const Leaf& leaf : leavesOf(node)) {
    sum += leaf.kappa;
  }
  return sum;
}

/// Mean distance (root mean square) of what leaves stand for to the nearer wall, by evidence.
double thicknessOf(const MapNode& node) {
  double sum = 0;
  for (const Leaf& leaf : leavesOf(node)) {
    const Belief b = unpackLeaf(leaf);
    const double to_x = b.mean.x() * b.mean.x() + b.cov(0, 0), to_y = b.mean.y() * b.mean.y() + b.cov(1, 1);
    sum += b.kappa * std::sqrt(std::min(to_x, to_y));
  }
  return sum / evidenceOf(node);
}

/// Five keyframes that saw a map of corners.
struct Scene {
  std::mt19937 random{3};
  Map map;
  GeometryWindow window;

  explicit Scene(int nodes, double kappa = 100) {
    std::vector<MapNode> corners;
    for (int n = 0; n < nodes; ++n) {
      corners.push_back(corner(n + 1, random, kappa));
    }
    map = Map::restore(corners, keyframes(20), {}, 1);
  }

  void add(int k, int count, int frames) {
    const Seen seen = seenFrom(map, k, count, random);
    window.add(k, seen.local, seen.pairs, frames, kMaxPoints);
  }
};

TEST(GeometryWindow, RefinesLeavesAndNothingElse) {
  Scene scene(10);
  for (int k = 0; k < 5; ++k) {
    scene.add(k, 400, 1);
  }
  const auto nodes = scene.window.refine(scene.map, kSigmaFloor);
  ASSERT_EQ(nodes.size(), 2U);  // a fifth
  MapUpdate update;
  update.changed = nodes;
  const Map before = scene.map;
  scene.map.apply(std::move(update));
  for (const auto& [id, node] : scene.map.nodes()) {
    const MapNode& was = *before.find(id);
    EXPECT_EQ(node.T_map_object.matrix(), was.T_map_object.matrix());
    EXPECT_EQ(node.belief.mean, was.belief.mean);
    EXPECT_EQ(node.belief.cov, was.belief.cov);
    EXPECT_EQ(node.belief.kappa, was.belief.kappa);
    EXPECT_EQ(node.label, was.label);
    EXPECT_EQ(node.stuff, was.stuff);
    EXPECT_EQ(node.tile, was.tile);
    EXPECT_EQ(node.views, was.views);
    EXPECT_EQ(node.anchor, was.anchor);
    const bool is_refined = std::ranges::any_of(nodes, [id = id](const MapNode& n) { return n.id == id; });
    EXPECT_EQ(sameLeaves(leavesOf(node), leavesOf(was)), !is_refined) << id;
  }
  ASSERT_EQ(scene.map.keyframes().poses().size(), before.keyframes().poses().size());
  for (std::size_t k = 0; k < before.keyframes().poses().size(); ++k) {
    EXPECT_EQ(scene.map.keyframes().poses()[k].T_map_body.matrix(), before.keyframes().poses()[k].T_map_body.matrix());
  }
}

TEST(GeometryWindow, EachNodeGetsItsTurnOnceInFiveKeyframes) {
  Scene scene(12);
  for (int k = 0; k < 5; ++k) {
    scene.add(k, 20, 1);
  }
  std::multiset<NodeId> turns;
  for (int k = 5; k < 10; ++k) {
    scene.add(k, 20, 1);
    for (const MapNode& node : scene.window.refine(scene.map, kSigmaFloor)) {
      turns.insert(node.id);
    }
  }
  EXPECT_EQ(turns.size(), 12U);
  for (const auto& [id, node] : scene.map.nodes()) {
    EXPECT_EQ(turns.count(id), 1U) << id;
  }
}

TEST(GeometryWindow, ANodeWithoutPointsInTheWindowIsNotTouched) {
  Scene scene(10);
  std::set<NodeId> touched;
  for (int k = 0; k < 12; ++k) {
    Seen seen;
    seen.add(*scene.map.find(1), poseOf(k), k < 2 ? 50 : 0, scene.random);
    seen.add(*scene.map.find(2), poseOf(k), 50, scene.random);
    scene.window.add(k, seen.local, seen.pairs, 1, kMaxPoints);
    for (const MapNode& node : scene.window.refine(scene.map, kSigmaFloor)) {
      EXPECT_TRUE(node.id == 2 || (node.id == 1 && k < 6)) << node.id << " at " << k;
      touched.insert(node.id);
    }
  }
  EXPECT_EQ(touched, (std::set<NodeId>{1, 2}));
}

/// `frames` make a point weigh as much as all frames since the last keyframe: more than the map was given where a robot
/// has stood still, or has only now seen a node.
TEST(GeometryWindow, KeepsTheEvidenceOfANode) {
  for (const double kappa : {2.0, 100.0, 5000.0}) {
    for (const int frames : {0, 1, 10, 1000}) {
      Scene scene(10, kappa);
      for (int k = 0; k < 5; ++k) {
        scene.add(k, 400, k == 4 ? frames : 1);
      }
      const auto nodes = scene.window.refine(scene.map, kSigmaFloor);
      ASSERT_FALSE(nodes.empty());
      for (const MapNode& node : nodes) {
        EXPECT_NEAR(evidenceOf(node), evidenceOf(*scene.map.find(node.id)), 0.01 * evidenceOf(node))
            << kappa << ", " << frames;
      }
    }
  }
}

TEST(GeometryWindow, SurfaceOutOfViewStaysBitForBit) {
  Scene scene(1, 5);  // little evidence beside the many points: none of it would be left
  MapNode node = *scene.map.find(1);
  const std::size_t seen = leavesOf(node).size();
  for (int n = 0; n < 10; ++n) {
    addLeaf(node, packLeaf({Vec3(30 + n, 30, 0), 0.01 * Mat3::Identity(), n == 0 ? 1.0 : 1000.0}));
  }
  const auto isUnseen = [](const Leaf& leaf) { return leaf.mean[0] > 20; };
  std::vector<Leaf> before(leavesOf(node).begin() + static_cast<std::ptrdiff_t>(seen), leavesOf(node).end());
  scene.map = Map::restore({node}, keyframes(40), {}, 1);
  int turns = 0;
  for (int k = 0; k < 40; ++k) {
    scene.add(k, 400, 1);
    MapUpdate update;
    update.changed = scene.window.refine(scene.map, kSigmaFloor);
    turns += update.changed.empty() ? 0 : 1;
    scene.map.apply(std::move(update));
  }
  EXPECT_GE(turns, 5);
  std::vector<Leaf> after;
  std::ranges::copy_if(*scene.map.geometry(1), std::back_inserter(after), isUnseen);
  EXPECT_TRUE(sameLeaves(before, after));
}

TEST(GeometryWindow, BlurredWallsBecomeSharper) {
  Scene scene(10);
  for (int k = 0; k < 5; ++k) {
    scene.add(k, 400, 1);
  }
  const auto nodes = scene.window.refine(scene.map, kSigmaFloor);
  ASSERT_FALSE(nodes.empty());
  for (const MapNode& node : nodes) {
    EXPECT_LT(thicknessOf(node), 0.8 * thicknessOf(*scene.map.find(node.id)));
  }
  const Map before = scene.map;
  for (int k = 5; k < 20; ++k) {  // three turns each
    scene.add(k, 400, 1);
    MapUpdate update;
    update.changed = scene.window.refine(scene.map, kSigmaFloor);
    scene.map.apply(std::move(update));
  }
  for (const auto& [id, node] : scene.map.nodes()) {
    EXPECT_LT(thicknessOf(node), 0.6 * thicknessOf(*before.find(id))) << id;
  }
}

/// Keyframes that a correction has moved lay their points where they are now.
TEST(GeometryWindow, PointsGoWithTheirKeyframe) {
  Scene scene(10);
  for (int k = 1; k < 6; ++k) {
    scene.add(k, 400, 1);
  }
  const auto meanOf = [](const MapNode& node) {
    Vec3 mean = Vec3::Zero();
    for (const Leaf& leaf : leavesOf(node)) {
      mean += leaf.kappa / evidenceOf(node) * (node.T_map_object * unpackLeaf(leaf).mean);
    }
    return mean;
  };
  const auto before = scene.window.refine(scene.map, kSigmaFloor);
  MapCorrection correction;
  for (KeyframeId k = 1; k < 6; ++k) {  // nodes are anchored to the first
    Pose T = poseOf(k);
    T.translation() += Vec3(0, 0, 0.05);
    correction.moved.emplace_back(k, T);
  }
  scene.map.apply(correction);
  const auto after = scene.window.refine(scene.map, kSigmaFloor);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t n = 0; n < after.size(); ++n) {
    const Vec3 shift = meanOf(after[n]) - meanOf(before[n]);
    EXPECT_GT(shift.z(), 0.005);
    EXPECT_LT(shift.norm(), 0.05);
  }
}

std::vector<MapNode> refinedBy(const Scene& scene, const Seen& seen, int frames, int max_points) {
  GeometryWindow window;
  window.add(4, seen.local, seen.pairs, frames, max_points);
  return window.refine(scene.map, kSigmaFloor);
}

TEST(GeometryWindow, AFrameOfNoMorePointsThanAllowedIsUsedWhole) {
  Scene scene(1);
  const Seen seen = seenFrom(scene.map, 4, 300, scene.random);
  const auto all = refinedBy(scene, seen, 1, 20000), enough = refinedBy(scene, seen, 1, 300),
             fewer = refinedBy(scene, seen, 1, 299);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(sameLeaves(leavesOf(all[0]), leavesOf(enough[0])));
  EXPECT_FALSE(sameLeaves(leavesOf(all[0]), leavesOf(fewer[0])));
}

TEST(GeometryWindow, OfMorePointsEveryNthIsUsedAndWeighsN) {
  Scene scene(1);
  Seen seen;
  seen.add(*scene.map.find(1), poseOf(4), 250, scene.random);
  Seen third;  // points 0, 3, ... of the frame
  third.pairs = seen.pairs;
  third.local.objects = seen.local.objects;
  for (std::size_t k = 0; k < seen.local.points.size(); k += 3) {
    third.local.points.push_back(seen.local.points[k]);
  }
  third.local.objects[0].end = third.local.points.size();
  EXPECT_LE(third.local.points.size(), 100U);
  const auto strided = refinedBy(scene, seen, 1, 100), again = refinedBy(scene, seen, 1, 100),
             picked = refinedBy(scene, third, 3, 20000);
  ASSERT_EQ(strided.size(), 1U);
  EXPECT_TRUE(sameLeaves(leavesOf(strided[0]), leavesOf(again[0])));
  EXPECT_TRUE(sameLeaves(leavesOf(strided[0]), leavesOf(picked[0])));
}

TEST(GeometryWindow, EmptyFramesAreFrames) {
  Scene scene(10);
  EXPECT_TRUE(scene.window.refine(scene.map, kSigmaFloor).empty());
  scene.window.add(0, LocalGraph{}, {}, 0, kMaxPoints);
  EXPECT_TRUE(scene.window.refine(scene.map, kSigmaFloor).empty());
  scene.add(1, 100, 1);
  scene.window.add(2, LocalGraph{}, {}, 3, kMaxPoints);
  EXPECT_EQ(scene.window.refine(scene.map, kSigmaFloor).size(), 2U);
}

TEST(GeometryWindow, ANodeRemovedSinceIsSkipped) {
  Scene scene(10);
  for (int k = 0; k < 5; ++k) {
    scene.add(k, 100, 1);
  }
  const auto before = scene.window.refine(scene.map, kSigmaFloor);
  ASSERT_EQ(before.size(), 2U);
  MapUpdate update;
  update.removed = {before[0].id};
  scene.map.apply(std::move(update));
  const auto after = scene.window.refine(scene.map, kSigmaFloor);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after[0].id, before[1].id);
  EXPECT_TRUE(sameLeaves(leavesOf(after[0]), leavesOf(before[1])));
}

TEST(GeometryWindow, ANodeWithoutLeavesStaysWithout) {
  Scene scene(1);
  const Seen seen = seenFrom(scene.map, 4, 50, scene.random);
  MapNode bare = *scene.map.find(1);
  bare.geometry = noLeaves();
  scene.map = Map::restore({bare}, scene.map.keyframes(), {}, 1);
  for (const MapNode& node : refinedBy(scene, seen, 1, 20000)) {
    EXPECT_TRUE(leavesOf(node).empty());
  }
}

}  // namespace
}  // namespace hgg::geometry_window_test
