#include "correction/between.h"

#include <gtest/gtest.h>

#include "core/units.h"
#include "map/test_map.h"

namespace hgg::between_test {
namespace {

constexpr ClassId kCar = 10;

Pose at(double x, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(x, 0, 0);
  return T;
}

Vec6 alongX() { return Vec6::Unit(0); }
Vec6 aroundZ() { return Vec6::Unit(5); }

Alignment alignedBut(std::vector<Vec6> degenerate) {
  Alignment alignment;
  alignment.leaf_pairs = 100;
  alignment.degenerate_directions = std::move(degenerate);
  return alignment;
}

Travel propagate(const Travel& travel, const Pose& T_last_body, const Alignment& alignment, bool is_jump = false) {
  return propagateTravel(travel, T_last_body, alignment, is_jump, AlignmentConfig{}, MapConfig{}.leaf_size);
}

/// A hundred metres in steps of one.
Travel driven(const Alignment& alignment, double turn_deg = 0) {
  Travel travel;
  for (int k = 0; k < 100; ++k) {
    travel = propagate(travel, at(1, turn_deg), alignment);
  }
  return travel;
}

TEST(PropagateTravel, AnAlignedWayLosesLittle) {
  const Travel travel = driven(alignedBut({}));
  EXPECT_NEAR(travel.sigma, std::sqrt(50.0) * 0.05 * Config{}.map.leaf_size, 1e-9);
  EXPECT_NEAR(travel.sigma_turn, std::sqrt(50.0) * 0.04 * kDegree, 1e-9);
  EXPECT_LT(travel.sigma, 0.2);
  EXPECT_LT(travel.sigma_turn, 0.3 * kDegree);
  EXPECT_FALSE(travel.jumped);
}

Alignment alignedWithin(double deviation, double turn) {
  Alignment alignment = alignedBut({});
  alignment.pose.information.diagonal() << Vec3::Constant(1 / square(deviation)), Vec3::Constant(1 / square(turn));
  return alignment;
}

TEST(PropagateTravel, WhatIsExpectedFollowsHowWellFramesAreAligned) {
  const double turn = 0.1 * kDegree;
  const Travel travel = driven(alignedWithin(0.01, turn));
  // A metre renews a tenth of a view of 25 leaf sizes; 0.3 of the error of each view is fresh.
  EXPECT_NEAR(travel.expected, 0.3 * 0.01 * std::sqrt(100 / (25 * Config{}.map.leaf_size)), 1e-12);
  EXPECT_NEAR(travel.expected_turn, 0.3 * turn * std::sqrt(100 / (25 * Config{}.map.leaf_size)), 1e-12);
  const Travel blunt = driven(alignedWithin(0.1, 10 * turn));
  EXPECT_NEAR(blunt.expected, 10 * travel.expected, 1e-12);
  EXPECT_EQ(blunt.sigma, travel.sigma) << "what may be matched is as cautious as before";
}

TEST(PropagateTravel, OfAWayThatOdometryAloneTellsItsErrorIsExpected) {
  const AlignmentConfig odometry;
  const Travel lost = driven({});
  EXPECT_NEAR(lost.expected, odometry.odometry_drift * std::sqrt(100.0), 1e-12);
  EXPECT_NEAR(lost.expected_turn, odometry.odometry_turn_deg * kDegree * std::sqrt(100.0), 1e-12);
  const Travel corridor = driven(alignedBut({alongX()}));
  EXPECT_NEAR(corridor.expected, lost.expected / std::sqrt(3.0), 1e-12) << "one of three directions";
  EXPECT_EQ(corridor.expected_turn, 0);
  const Travel jumped = propagate({}, at(1), {}, true);
  EXPECT_EQ(jumped.expected, jumped.sigma);
  EXPECT_EQ(jumped.expected_turn, jumped.sigma_turn);
}

TEST(PropagateTravel, HowOftenTheWayWasAlignedIsNoMatter) {
  Travel often;
  for (int k = 0; k < 1000; ++k) {
    often = propagate(often, at(0.1), alignedBut({}));
  }
  EXPECT_NEAR(often.sigma, driven(alignedBut({})).sigma, 1e-9);
}

TEST(PropagateTravel, OdometrysWayLosesWhatOdometryDoes) {
  Config config;
  const Travel straight = driven({});
  EXPECT_NEAR(straight.sigma, config.alignment.odometry_drift * 100, 1e-9);
  EXPECT_NEAR(straight.sigma_turn, config.alignment.odometry_turn_deg * kDegree * 100, 1e-9);
  const Travel turning = driven({}, 5);
  EXPECT_NEAR(turning.sigma_turn - straight.sigma_turn, config.alignment.odometry_drift * 500 * kDegree, 1e-9);
  EXPECT_EQ(propagate({}, Pose::Identity(), {}).sigma, 0);
}

TEST(PropagateTravel, WhatIsDegenerateInPositionOnlyKeepsItsHeading) {
  const Travel aligned = driven(alignedBut({})), odometry = driven({});
  const Travel in_corridor = driven(alignedBut({alongX()}));
  EXPECT_EQ(in_corridor.sigma, odometry.sigma);
  EXPECT_EQ(in_corridor.sigma_turn, aligned.sigma_turn);
  const Travel on_ice = driven(alignedBut({aroundZ()}));
  EXPECT_EQ(on_ice.sigma, aligned.sigma);
  EXPECT_EQ(on_ice.sigma_turn, odometry.sigma_turn);
  const Travel lost = driven(alignedBut({alongX(), aroundZ()}));
  EXPECT_EQ(lost.sigma, odometry.sigma);
  EXPECT_EQ(lost.sigma_turn, odometry.sigma_turn);
}

TEST(PropagateTravel, AJumpIsForgottenByAFrameThatTheMapHoldsInEveryDirection) {
  const Travel once = propagate({}, at(1000, 100), alignedBut({}), true);
  EXPECT_TRUE(once.jumped) << "the way from the last keyframe stays unknown";
  EXPECT_LT(once.sigma, 0.1);
  const Travel later = propagate(propagate({}, at(1000, 100), {}, true), at(1), alignedBut({}));
  EXPECT_TRUE(later.jumped);
  EXPECT_LT(later.sigma, 0.1);
}

TEST(PropagateTravel, AJumpIsLostByThirtyCentimetresAndThreeDegreesWhileTheMapDoesNotHoldThePose) {
  const Travel once = propagate({}, at(1000, 100), {}, true);
  EXPECT_NEAR(once.sigma, 0.3, 1e-12);
  EXPECT_NEAR(once.sigma_turn, 3 * kDegree, 1e-12);
  const Travel later = propagate(once, at(1), alignedBut({alongX(), aroundZ()}));
  EXPECT_TRUE(later.jumped);
  EXPECT_GT(later.sigma, 0.3);
  EXPECT_NEAR(propagate({0.4, 4 * kDegree}, at(1), {}, true).sigma, 0.5, 1e-12);
  EXPECT_NEAR(propagate({0.4, 4 * kDegree}, at(1), {}, true).sigma_turn, 5 * kDegree, 1e-12);
}

/// A map with a keyframe every 3 m along x and a car made at each; and a frame that was aligned with all of them, with
/// this many leaves of each.
struct Scene {
  Map map;
  LocalGraph local;
  Alignment alignment = alignedBut({});

  explicit Scene(const std::vector<int>& leaves_of) {
    for (std::size_t k = 0; k < leaves_of.size(); ++k) {
      MapUpdate update;
      update.keyframe = NewKeyframe{{static_cast<Micros>(k), at(3.0 * static_cast<double>(k))}, {}};
      update.created = {nodeAt(kCar, Vec3(3.0 * static_cast<double>(k), 5, 0))};
      map.apply(std::move(update));
      LocalObject object;
      object.leaves.resize(static_cast<std::size_t>(leaves_of[k]));
      local.objects.push_back(object);
      alignment.pairs.push_back({static_cast<int>(k), static_cast<NodeId>(k) + 1, 0});
    }
  }

  std::vector<BetweenConstraint> constraints(const Pose& T_map_body,
                                             const Travel& travel = {0.01, 0.001, false}) const {
    return betweenConstraints(T_map_body, map, local, alignment, travel, MapConfig{}.leaf_size);
  }
};

std::vector<KeyframeId> endsOf(const std::vector<BetweenConstraint>& constraints) {
  std::vector<KeyframeId> ends;
  for (const BetweenConstraint& e : constraints) {
    ends.push_back(e.a);
  }
  return ends;
}

TEST(BetweenConstraints, GoToTheLastKeyframeAndToTheTwoThatMostLeavesBelongTo) {
  const Scene scene({20, 50, 5, 70, 30, 90});
  const Pose T = at(18, 30);
  const auto constraints = scene.constraints(T);
  EXPECT_EQ(endsOf(constraints),
            (std::vector<KeyframeId>{5, 3, 1}));  // the last one has most and its constraint already
  for (const BetweenConstraint& e : constraints) {
    const Pose& T_map_a = scene.map.keyframes().poses()[static_cast<std::size_t>(e.a)].T_map_body;
    EXPECT_TRUE((T_map_a * e.T_a_b).isApprox(T, 1e-12));
    EXPECT_FALSE(e.is_loop);
  }
  EXPECT_EQ(constraints[0].sigma, 0.01);
  EXPECT_EQ(constraints[0].sigma_turn, 0.001);
  EXPECT_NEAR(constraints[1].sigma, 0.05, 1e-12);  // an eighth of a leaf
  EXPECT_NEAR(constraints[1].sigma_turn, 0.2 * kDegree, 1e-12);
}

TEST(BetweenConstraints, FewLeavesConstrainNothing) {
  EXPECT_EQ(endsOf(Scene({9, 0, 100}).constraints(at(9))), (std::vector<KeyframeId>{2}));
  EXPECT_EQ(endsOf(Scene({12, 0, 100}).constraints(at(9))), (std::vector<KeyframeId>{2, 0}));
}

TEST(BetweenConstraints, NodesOfNoKeyframeConstrainNothing) {
  Scene scene({50, 50, 50});
  std::vector<MapNode> nodes;
  for (const auto& [id, node] : scene.map.nodes()) {
    nodes.push_back(node);
    nodes.back().anchor = -1;
  }
  scene.map = Map::restore(nodes, scene.map.keyframes(), {}, 1);
  EXPECT_EQ(endsOf(scene.constraints(at(9))), (std::vector<KeyframeId>{2}));
}

TEST(BetweenConstraints, APoseThatTheMapDoesNotConstrainGetsOneToTheLastKeyframeOnly) {
  Scene scene({50, 50, 50});
  scene.alignment.degenerate_directions = {alongX()};
  EXPECT_EQ(endsOf(scene.constraints(at(9))), (std::vector<KeyframeId>{2}));
  scene.alignment.degenerate_directions.clear();
  scene.alignment.leaf_pairs = 0;
  EXPECT_EQ(endsOf(scene.constraints(at(9))), (std::vector<KeyframeId>{2}));
}

TEST(BetweenConstraints, AnEmptyMapHasNone) {
  EXPECT_TRUE(betweenConstraints(at(1), {}, {}, {}, {}, MapConfig{}.leaf_size).empty());
}

TEST(BetweenConstraints, NoneIsWithoutError) {
  for (const BetweenConstraint& e : Scene({50}).constraints(at(3), {})) {
    EXPECT_GT(e.sigma, 0);
    EXPECT_GT(e.sigma_turn, 0);
  }
}

TEST(BetweenConstraints, AfterAJumpTheyGoToWhatWasAlignedWithAloneOrElseToTheNearestKeyframe) {
  Scene scene({0, 0, 0, 0, 0, 50});
  scene.alignment.leaf_pairs = 0;
  const Travel jumped{0.3, 3 * kDegree, true};
  EXPECT_EQ(endsOf(scene.constraints(at(4), jumped)), (std::vector<KeyframeId>{1}));
  EXPECT_EQ(scene.constraints(at(4), jumped)[0].sigma, 0.3);
  EXPECT_EQ(endsOf(scene.constraints(at(-50), jumped)), (std::vector<KeyframeId>{0}));
  scene.alignment.leaf_pairs = 100;
  EXPECT_EQ(endsOf(scene.constraints(at(4), jumped)), (std::vector<KeyframeId>{5}));
  EXPECT_NEAR(scene.constraints(at(4), jumped)[0].sigma, 0.05, 1e-12);
}

TEST(BetweenConstraints, AfterAJumpTheyAreAsCertainAsTheMapWhereItConstrainsThePoseAndAsTheGuessElsewhere) {
  Scene scene({50, 0, 0});
  const Travel jumped{0.3, 3 * kDegree, true};
  scene.alignment.degenerate_directions = {alongX()};
  auto constraints = scene.constraints(at(6), jumped);
  ASSERT_EQ(endsOf(constraints), (std::vector<KeyframeId>{0}));
  EXPECT_EQ(constraints[0].sigma, 0.3);
  EXPECT_NEAR(constraints[0].sigma_turn, 0.2 * kDegree, 1e-12);
  scene.alignment.degenerate_directions = {aroundZ()};
  constraints = scene.constraints(at(6), jumped);
  EXPECT_NEAR(constraints[0].sigma, 0.05, 1e-12);
  EXPECT_EQ(constraints[0].sigma_turn, 3 * kDegree);
}

}  // namespace
}  // namespace hgg::between_test
