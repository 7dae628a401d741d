#include "correction/pose_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "map/test_map.h"

namespace hgg::pose_window_test {
namespace {

constexpr ClassId kPole = 80;
constexpr double kKappa = 200;                          // points of an observation
constexpr double kMoveSigma = 0.08, kTurnSigma = 0.01;  // m, rad, from one keyframe to the next
constexpr double kLeafSize = 0.4;                       // m

Pose offBy(std::mt19937& random, double sigma, double sigma_turn) {
  std::normal_distribution<double> normal(0, 1);
  Vec6 xi;
  for (double& value : xi) {
    value = normal(random);
  }
  xi.head<3>() *= sigma;
  xi.tail<3>() *= sigma_turn;
  return retract(Pose::Identity(), xi);
}

/// A drive that odometry alone has placed in the map, past poles that every keyframe sees as they are.
struct DriftingDrive {
  std::vector<Pose> truth;
  std::vector<MapNode> poles;
  Map map;
  PoseWindow window;

  DriftingDrive(int keyframes, int objects, double step = 2, double sigma = kMoveSigma,
                double sigma_turn = kTurnSigma) {
    std::mt19937 random(1);
    KeyframeGraph graph;
    Pose T = Pose::Identity();
    for (int k = 0; k < keyframes; ++k) {
      Pose onward = Pose::Identity();
      onward.linear() = Eigen::AngleAxisd(0.05 * step, Vec3::UnitZ()).toRotationMatrix();
      onward.translation() = Vec3(step, 0, 0);
      truth.push_back(k == 0 ? Pose::Identity() : truth.back() * onward);
      const Pose measured = onward * offBy(random, sigma, sigma_turn);
      T = k == 0 ? T : T * measured;
      graph.add({1000 * k, T});
      if (k > 0) {
        graph.connect({k - 1, k, measured, sigma, sigma_turn, false});
      }
    }
    for (int i = 0; i < objects; ++i) {
      poles.push_back(nodeAt(kPole, Vec3(10, 0, 0) + randomVector(random, 12), 0.1, keyframes * kKappa));
      poles.back().id = i + 1;
      poles.back().anchor = 0;
      poles.back().geometry = shareLeaves({randomLeaf(random), randomLeaf(random), randomLeaf(random)});
    }
    map = Map::restore(poles, graph, {}, 1);
  }

  /// What keyframe k sees of the poles from the `first` on.
  void add(int k, const Alignment& how = {}, std::size_t first = 0) {
    LocalGraph local;
    Alignment alignment = how;
    for (std::size_t i = first; i < poles.size(); ++i) {
      LocalObject object;
      object.label = kPole;
      object.belief = transform(truth[static_cast<std::size_t>(k)].inverse(), poles[i].belief);
      object.belief.kappa = kKappa;
      alignment.pairs.push_back({static_cast<int>(local.objects.size()), poles[i].id, 0});
      local.objects.push_back(object);
    }
    window.add(map, k, local, alignment);
  }

  DriftingDrive& addAll(std::size_t first = 0) {
    for (int k = 0; k < static_cast<int>(truth.size()); ++k) {
      add(k, {}, first);
    }
    return *this;
  }

  double error() const {
    double sum = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      sum += (map.keyframes().poses()[k].T_map_body.translation() - truth[k].translation()).norm();
    }
    return sum / static_cast<double>(truth.size());
  }
};

Alignment alignedByLeaves() {
  Alignment alignment;
  alignment.leaf_pairs = 500;
  return alignment;
}

bool isFinite(const MapCorrection& correction) {
  return std::ranges::all_of(correction.moved, [](const auto& m) { return m.second.matrix().allFinite(); });
}

TEST(PoseWindow, HasNothingToSolveWithFewerThanTwoKeyframes) {
  DriftingDrive drive(3, 12);
  EXPECT_FALSE(drive.window.solve(drive.map, kLeafSize, {}));
  drive.add(0);
  EXPECT_FALSE(drive.window.solve(drive.map, kLeafSize, {}));
}

TEST(PoseWindow, LeavesPosesAloneWhileLeavesAlignTheNewest) {
  DriftingDrive drive(5, 12);
  for (int k = 0; k < 4; ++k) {
    drive.add(k);
  }
  EXPECT_TRUE(drive.window.solve(drive.map, kLeafSize, {}));
  drive.add(4, alignedByLeaves());
  EXPECT_FALSE(drive.window.solve(drive.map, kLeafSize, {}));
}

TEST(PoseWindow, LeavesAPoseAloneThatLeavesAlignInSomeDirectionsOnly) {
  DriftingDrive drive(5, 12);
  for (int k = 0; k < 4; ++k) {
    drive.add(k);
  }
  Alignment along_a_wall = alignedByLeaves();
  along_a_wall.degenerate_directions.push_back(Vec6::Unit(0));
  drive.add(4, along_a_wall);
  EXPECT_FALSE(drive.window.solve(drive.map, kLeafSize, {}));
}

TEST(PoseWindow, ObjectsBringPosesThatDriftCloserToTheTruth) {
  DriftingDrive drive(10, 12);
  drive.addAll();
  const double before = drive.error();
  const auto correction = drive.window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(correction);
  EXPECT_EQ(correction->moved.size(), 10U);
  EXPECT_TRUE(correction->loops.empty());
  drive.map.apply(*correction);
  EXPECT_GT(before, 0.1);
  EXPECT_LT(drive.error(), 0.5 * before);
}

TEST(PoseWindow, AnObjectThatWasMadeInTheWindowHoldsNoPose) {
  // What frames between keyframes have made of it goes with their drift, however much it is.
  std::vector<MapCorrection> found;
  for (const double kappa : {1.0, 1e6}) {
    DriftingDrive drive(10, 12);
    std::vector<MapNode> nodes = drive.poles;
    for (MapNode& node : nodes) {
      node.belief.mean += Vec3(0.5, 0.2, 0);
      node.belief.kappa = kappa;
      node.anchor = 0;  // the first keyframe of the window
    }
    drive.map = Map::restore(nodes, drive.map.keyframes(), {}, 1);
    found.push_back(drive.addAll().window.solve(drive.map, kLeafSize, {}).value_or(MapCorrection{}));
  }
  ASSERT_EQ(found[0].moved.size(), 10U);
  ASSERT_EQ(found[1].moved.size(), 10U);
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_TRUE(found[0].moved[k].second.isApprox(found[1].moved[k].second, 1e-12)) << k;
  }
}

TEST(PoseWindow, AnObjectFromBeforeTheWindowPullsWhatSeesItToIt) {
  double height[2];
  for (const int anchor : {-1, 0}) {  // from before the window, made in it
    DriftingDrive drive(10, 12);
    std::vector<MapNode> nodes = drive.poles;
    for (MapNode& node : nodes) {
      node.belief.mean.z() += 0.3;
      node.belief.kappa = 1e4;
      node.anchor = anchor;
    }
    drive.map = Map::restore(nodes, drive.map.keyframes(), {}, 1);
    const auto correction = drive.addAll().window.solve(drive.map, kLeafSize, {});
    ASSERT_TRUE(correction);
    height[anchor + 1] = correction->moved.back().second.translation().z();
  }
  EXPECT_GT(height[0], height[1] + 0.1);
  EXPECT_LT(std::abs(height[1]), 0.1);
}

TEST(PoseWindow, ConstraintsFollowTheWindowAndLoopsDoNot) {
  DriftingDrive drive(10, 12);
  KeyframeGraph graph = drive.map.keyframes();
  graph.connect({2, 7, Pose::Identity(), 0.1, 0.01, true});
  drive.map = Map::restore(drive.poles, graph, {}, 1);
  const auto correction = drive.addAll().window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(correction);
  drive.map.apply(*correction);
  const KeyframeGraph& after = drive.map.keyframes();
  for (const BetweenConstraint& e : after.edges()) {
    const Pose T_a_b = after.poses()[static_cast<std::size_t>(e.a)].T_map_body.inverse() *
                       after.poses()[static_cast<std::size_t>(e.b)].T_map_body;
    EXPECT_EQ(e.T_a_b.isApprox(T_a_b, 1e-9), !e.is_loop) << e.a << " to " << e.b;
  }
}

TEST(PoseWindow, ForgetsKeyframesOlderThanTen) {
  DriftingDrive drive(14, 12);
  drive.addAll();
  const auto correction = drive.window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(correction);
  ASSERT_EQ(correction->moved.size(), 10U);
  EXPECT_EQ(correction->moved.front().first, 4);
  EXPECT_EQ(correction->moved.back().first, 13);
}

TEST(PoseWindow, ACorrectionChangesNoLeafInsideAnyObject) {
  DriftingDrive drive(10, 12);
  const auto correction = drive.addAll().window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(correction);
  const Map before = drive.map;
  const MapDelta delta = drive.map.apply(*correction);
  EXPECT_FALSE(delta.moved.empty());
  EXPECT_TRUE(delta.changed.empty());
  for (const auto& [id, node] : drive.map.nodes()) {
    const MapNode& was = *before.find(id);
    ASSERT_EQ(leavesOf(node).size(), leavesOf(was).size());
    EXPECT_EQ(std::memcmp(leavesOf(node).data(), leavesOf(was).data(), leavesOf(was).size() * sizeof(Leaf)), 0) << id;
    EXPECT_EQ(node.belief.kappa, was.belief.kappa);
    EXPECT_EQ(node.views, was.views);
  }
}

TEST(PoseWindow, NodesThatAreGoneAreLeftOut) {
  DriftingDrive drive(10, 12), without(10, 12);
  drive.addAll();
  without.addAll(4);
  for (Map* map : {&drive.map, &without.map}) {
    MapUpdate update;
    update.removed = {1, 2, 3, 4};
    map->apply(std::move(update));
  }
  const auto a = drive.window.solve(drive.map, kLeafSize, {}), b = without.window.solve(without.map, kLeafSize, {});
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->moved.size(), b->moved.size());
  for (std::size_t k = 0; k < a->moved.size(); ++k) {
    EXPECT_EQ(a->moved[k].second.matrix(), b->moved[k].second.matrix()) << k;
  }
}

TEST(PoseWindow, StuffMovesNoPose) {
  DriftingDrive drive(3, 12);
  LocalGraph road;
  road.objects.resize(1);
  road.objects[0].stuff = true;
  road.objects[0].belief = {Vec3(5, 5, 5), Mat3::Identity(), 1e6};
  Alignment alignment;
  alignment.pairs = {{0, 1, 0}};
  for (int k = 0; k < 3; ++k) {
    drive.window.add(drive.map, k, road, alignment);
  }
  EXPECT_FALSE(drive.window.solve(drive.map, kLeafSize, {}));
}

TEST(PoseWindow, WithoutObjectsOrConstraintsIsFinite) {
  DriftingDrive drive(4, 0);
  EXPECT_FALSE(drive.addAll().window.solve(drive.map, kLeafSize, {})) << "poses lie as they were measured";
  drive.map.apply(MapCorrection{{{2, Pose::Identity()}}, {}});
  const auto back = drive.window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(back);
  EXPECT_TRUE(isFinite(*back));

  KeyframeGraph loose;
  for (int k = 0; k < 4; ++k) {
    loose.add({k, drive.truth[static_cast<std::size_t>(k)]});
  }
  const auto adrift = drive.window.solve(Map::restore({}, loose, {}, 1), kLeafSize, {});
  EXPECT_TRUE(!adrift || isFinite(*adrift));
}

TEST(PoseWindow, ARobotAtRestGetsAFiniteAnswer) {
  DriftingDrive drive(10, 12, 0, 0, 0);
  std::mt19937 random(2);
  for (Pose& T : drive.truth) {
    T = offBy(random, 0.02, 0.002);  // each observation is off by a little
  }
  const auto correction = drive.addAll().window.solve(drive.map, kLeafSize, {});
  ASSERT_TRUE(correction);
  ASSERT_TRUE(isFinite(*correction));
  for (const auto& [id, T] : correction->moved) {
    EXPECT_LE(T.translation().norm(), 0.02) << id;
    EXPECT_LE((T.linear().transpose() * T.linear() - Mat3::Identity()).norm(), 1e-9) << id;
  }
}

TEST(PoseWindow, SolvesTheSameTwice) {
  DriftingDrive a(10, 12), b(10, 12);
  const auto of_a = a.addAll().window.solve(a.map, kLeafSize, {}), of_b = b.addAll().window.solve(b.map, kLeafSize, {});
  ASSERT_TRUE(of_a && of_b);
  for (std::size_t k = 0; k < of_a->moved.size(); ++k) {
    EXPECT_EQ(of_a->moved[k].second.matrix(), of_b->moved[k].second.matrix());
  }
}

}  // namespace
}  // namespace hgg::pose_window_test
