#include "alignment/correspondence.h"

#include <gtest/gtest.h>

#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::correspondence_test {
namespace {

LocalObject objectAt(ClassId label, const Vec3& mean, double deviation = 0.5, double kappa = 50) {
  LocalObject object;
  object.label = label;
  object.belief = {mean, deviation * deviation * Mat3::Identity(), kappa};
  object.T_body_object.translation() = mean;
  return object;
}

LocalGraph graphOf(std::vector<LocalObject> objects, std::vector<std::pair<int, int>> edges = {}) {
  LocalGraph graph;
  graph.objects = std::move(objects);
  graph.edges = std::move(edges);
  return graph;
}

/// Geometry alone decides, so that costs are plain distances.
Config geometryOnly(double gate) {
  Config config;
  config.alignment.geometry_share = 1;
  config.alignment.gate = gate;
  return config;
}

std::vector<ObjectPair> match(const LocalGraph& local, const Map& map, const Config& config,
                              const Pose& T = Pose::Identity()) {
  return coarseCorrespondence(local, map, T, config);
}

TEST(FineCorrespondence, StructureDecidesBetweenLeavesWhereItIsAskedFor) {
  const Mat3 plate = Vec3(0.04, 0.04, 0.0001).asDiagonal(), ball = 0.02 * Mat3::Identity();
  MapNode node = nodeAt(kCar, Vec3(5, 0, 0));
  node.geometry = shareLeaves({packLeaf({Vec3(0.1, 0, 0), ball, 50}), packLeaf({Vec3(0.3, 0, 0), plate, 50})});
  LocalObject car = objectAt(kCar, Vec3(5, 0, 0));
  car.leaves = {{Vec3(0.12, 0, 0), plate, 50}, {Vec3(0.28, 0, 0), ball, 50}};
  const Map map = mapOf({node});
  const std::vector<ObjectPair> pairs{{0, 1, 0}};
  for (const double share : {1.0, 0.5}) {
    Config config;
    config.alignment.leaf_geometry_share = share;
    const auto found = fineCorrespondence(graphOf({car}), map, pairs, Pose::Identity(), config.alignment, 0.01);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0].map, share == 1 ? 0 : 1);
    EXPECT_EQ(found[1].map, share == 1 ? 1 : 0);
  }
}

TEST(CoarseCorrespondence, ClassIsHard) {
  const Map map = mapOf({nodeAt(kPole, Vec3(5, 0, 0)), nodeAt(kCar, Vec3(6, 0, 0))});
  const auto pairs = match(graphOf({objectAt(kCar, Vec3(5, 0, 0))}), map, geometryOnly(3));
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].map, 2);  // a metre off, where the pole is right there
  EXPECT_TRUE(match(graphOf({objectAt(kRoad, Vec3(5, 0, 0))}), map, geometryOnly(3)).empty());
}

TEST(CoarseCorrespondence, APairBeyondTheGateStaysUnmatched) {
  const Map map = mapOf({nodeAt(kCar, Vec3(5, 0, 0))});
  EXPECT_EQ(match(graphOf({objectAt(kCar, Vec3(6.99, 0, 0))}), map, geometryOnly(2)).size(), 1U);
  EXPECT_TRUE(match(graphOf({objectAt(kCar, Vec3(7.01, 0, 0))}), map, geometryOnly(2)).empty());
  // Extents count too: a mean on the spot does not make a bus a pole.
  EXPECT_TRUE(match(graphOf({objectAt(kCar, Vec3(5, 0, 0), 4)}), map, geometryOnly(2)).empty());
}

TEST(CoarseCorrespondence, TheSearchReachesAsFarAsTheGateAllowsForAnyShare) {
  Config config;
  config.alignment.geometry_share = 0.5, config.alignment.gate = 2;  // 0.5 W2 < 2 up to 4 m
  const Map map = mapOf({nodeAt(kCar, Vec3(5, 0, 0))});
  EXPECT_EQ(match(graphOf({objectAt(kCar, Vec3(8.9, 0, 0))}), map, config).size(), 1U);
  EXPECT_TRUE(match(graphOf({objectAt(kCar, Vec3(9.1, 0, 0))}), map, config).empty());
}

TEST(CoarseCorrespondence, IsOneToOneAndTheBetterFragmentWins) {
  const Map map = mapOf({nodeAt(kCar, Vec3(5, 0, 0))});
  const auto pairs =
      match(graphOf({objectAt(kCar, Vec3(6, 0, 0)), objectAt(kCar, Vec3(5.2, 0, 0)), objectAt(kCar, Vec3(4, 0, 0))}),
            map, geometryOnly(3));
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].local, 1);
  EXPECT_NEAR(pairs[0].cost, 0.2, 1e-6);
}

TEST(CoarseCorrespondence, AShiftedRowOfCarsMatchesAsARowNotGreedily) {
  // Everything moved by 0.9 of the spacing: each object's nearest node is the wrong one.
  std::vector<MapNode> nodes;
  std::vector<LocalObject> objects;
  for (int k = 0; k < 5; ++k) {
    nodes.push_back(nodeAt(kCar, Vec3(k, 0, 0)));
    objects.push_back(objectAt(kCar, Vec3(k + 0.9, 0, 0)));
  }
  const auto pairs = match(graphOf(objects), mapOf(nodes), geometryOnly(5));
  ASSERT_EQ(pairs.size(), 5U);
  for (const ObjectPair& pair : pairs) {
    EXPECT_EQ(pair.map, pair.local + 1);
  }
}

TEST(CoarseCorrespondence, StuffMatchesItsTileAndNothingElse) {
  const Map map = mapOf({tileNode(kRoad, {0, 0, 0}, Vec3(-40, 0, 0)), tileNode(kRoad, {1, 0, 0}, Vec3(5, 0, 0))});
  LocalObject road = objectAt(kRoad, Vec3(5, 0, 0));
  road.stuff = true;
  const auto pairs = match(graphOf({road}), map, geometryOnly(3));
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].map, 1);  // tile (0, 0, 0), though its mean is 45 m off and the other's is on the spot
  EXPECT_EQ(pairs[0].cost, 0);
  road.tile = {2, 0, 0};
  EXPECT_TRUE(match(graphOf({road}), map, geometryOnly(3)).empty());
  road.tile = {0, 0, 0}, road.label = kCar;
  EXPECT_TRUE(match(graphOf({road}), map, geometryOnly(3)).empty());
}

TEST(CoarseCorrespondence, AThingNeverMatchesAStuffNodeOfAnOlderClassTable) {
  const Map map = mapOf({tileNode(kCar, {0, 0, 0}, Vec3(5, 0, 0))});
  EXPECT_TRUE(match(graphOf({objectAt(kCar, Vec3(5, 0, 0), 2)}), map, geometryOnly(3)).empty());
}

TEST(CoarseCorrespondence, NeighboursDecideBetweenTwinsAtTheSameDistance) {
  // Two cars left and right; only the left one has poles around it, and so has the car seen in the middle.
  Map map = mapOf({nodeAt(kCar, Vec3(0, 2, 0)), nodeAt(kCar, Vec3(0, -2, 0)), nodeAt(kPole, Vec3(1, 2.5, 0)),
                   nodeAt(kPole, Vec3(-1, 2.5, 0))});
  map.setEdgeModel({});
  const LocalGraph local = graphOf({objectAt(kCar, Vec3(0, 0, 0)), objectAt(kPole, Vec3(20, 0, 0)),
                                    objectAt(kPole, Vec3(20, 5, 0)), objectAt(kCar, Vec3(20, 9, 0))},
                                   {{0, 1}, {0, 2}, {0, 3}});
  Config config = geometryOnly(10);
  config.alignment.geometry_share = 0.5;
  const auto pairs = match(local, map, config);
  ASSERT_GE(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].local, 0);
  EXPECT_EQ(pairs[0].map, 1);
}

TEST(CoarseCorrespondence, NeighboursThatAreNotBelievedInDoNotCount) {
  // As before, but the poles around the left car are in doubt, and those around the right car are not.
  MapNode doubted = nodeAt(kPole, Vec3(1, 2.5, 0));
  doubted.classes = {};
  addViews(doubted.classes, {{kPole, 1.0F}, {kRoad, 1000.0F}});
  MapNode other = doubted;
  other.belief.mean = Vec3(-1, 2.5, 0);
  Map map = mapOf({nodeAt(kCar, Vec3(0, 2, 0)), nodeAt(kCar, Vec3(0, -2, 0)), doubted, other,
                   nodeAt(kPole, Vec3(1, -2.5, 0)), nodeAt(kPole, Vec3(-1, -2.5, 0))});
  map.setEdgeModel({});
  ASSERT_FALSE(isConfirmed(*map.find(3)));
  const LocalGraph local = graphOf({objectAt(kCar, Vec3(0, 0, 0)), objectAt(kPole, Vec3(20, 0, 0)),
                                    objectAt(kPole, Vec3(20, 5, 0)), objectAt(kCar, Vec3(20, 9, 0))},
                                   {{0, 1}, {0, 2}, {0, 3}});
  Config config = geometryOnly(10);
  config.alignment.geometry_share = 0.5;
  const auto pairs = match(local, map, config);
  ASSERT_GE(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].map, 2);
}

TEST(CoarseCorrespondence, ComparesInTheMapFrame) {
  Pose T_map_body = Pose::Identity();
  T_map_body.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  T_map_body.translation() = Vec3(100, 0, 0);
  const Map map = mapOf({nodeAt(kCar, Vec3(100, 5, 0)), nodeAt(kCar, Vec3(5, 0, 0))});
  const auto pairs = match(graphOf({objectAt(kCar, Vec3(5, 0, 0))}), map, geometryOnly(1), T_map_body);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].map, 1);
  EXPECT_NEAR(pairs[0].cost, 0, 1e-6);
}

TEST(CoarseCorrespondence, LeavesNodesBeyondTheActiveRadiusAlone) {
  Config config = geometryOnly(3);
  config.map.active_radius = 50;
  const Map map = mapOf({nodeAt(kCar, Vec3(49.5, 0, 0)), nodeAt(kCar, Vec3(0, 50.5, 0))});
  const auto pairs = match(graphOf({objectAt(kCar, Vec3(49.5, 0, 0)), objectAt(kCar, Vec3(0, 50.5, 0))}), map, config);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].local, 0);
}

TEST(CoarseCorrespondence, OfAnEmptyMapOrAnEmptyFrameIsEmpty) {
  EXPECT_TRUE(match(graphOf({objectAt(kCar, Vec3(5, 0, 0))}), Map{}, geometryOnly(3)).empty());
  EXPECT_TRUE(match({}, mapOf({nodeAt(kCar, Vec3(5, 0, 0))}), geometryOnly(3)).empty());
}

TEST(CoarseCorrespondence, OfACrowdIsSortedOneToOneAndCostsWhatTheEquationSays) {
  std::mt19937 random(1);
  std::vector<MapNode> nodes;
  std::vector<LocalObject> objects;
  for (int k = 0; k < 80; ++k) {
    const Vec3 at = randomVector(random, 15);
    nodes.push_back(nodeAt(k % 2 == 0 ? kCar : kPole, at));
    objects.push_back(objectAt(k % 2 == 0 ? kCar : kPole, at + randomVector(random, 0.3)));
  }
  const Map map = mapOf(nodes);
  const auto pairs = match(graphOf(objects), map, geometryOnly(1));
  std::vector<NodeId> ids;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const LocalObject& object = objects[static_cast<std::size_t>(pairs[i].local)];
    const MapNode& node = *map.find(pairs[i].map);
    EXPECT_EQ(object.label, node.label);
    EXPECT_NEAR(pairs[i].cost, wasserstein2(object.belief, node.belief), 1e-9);
    EXPECT_TRUE(i == 0 || pairs[i - 1].local < pairs[i].local);
    ids.push_back(pairs[i].map);
  }
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::unique(ids.begin(), ids.end()), ids.end());
  EXPECT_GE(pairs.size(), 70U);
}

}  // namespace
}  // namespace hgg::correspondence_test
