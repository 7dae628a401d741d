#include "map/drift.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "core/units.h"
#include "map/position.h"
#include "map/test_map.h"

namespace hgg::drift_test {
namespace {

constexpr ClassId kCar = 10;
constexpr double kStep = 0.02, kStepTurn = 0.2 * kDegree;  // m, rad

Vec6 noise(std::mt19937& random, const BetweenConstraint& e) {
  std::normal_distribution<double> normal(0, 1);
  Vec6 xi;
  for (Eigen::Index k = 0; k < 6; ++k) {
    xi[k] = normal(random) * (k < 3 ? e.expected : e.expected_turn);
  }
  return xi;
}

/// A way that bends to the left and climbs, a keyframe every two metres.
KeyframeGraph chain(int count) {
  KeyframeGraph graph;
  Pose T = Pose::Identity(), step = Pose::Identity();
  step.translation() = Vec3(2, 0, 0.1);
  step.linear() = Eigen::AngleAxisd(7 * kDegree, Vec3(0.1, 0.2, 1).normalized()).toRotationMatrix();
  for (int k = 0; k < count; ++k) {
    graph.add({k, T});
    T = T * step;
    if (k > 0) {
      graph.connect({k - 1, k, step, 1, 1, false, kStep * (1 + k % 3), kStepTurn});
    }
  }
  return graph;
}

const Pose& poseOf(const KeyframeGraph& graph, KeyframeId id) {
  return graph.poses()[static_cast<std::size_t>(id)].T_map_body;
}

/// The poses that the constraints of a chain make when each is wrong by its noise, the first keyframe being at its
/// place. A constraint names its keyframes in either order.
std::vector<Pose> drawn(const KeyframeGraph& graph, std::mt19937& random) {
  std::vector<Pose> poses{poseOf(graph, 0)};
  for (const BetweenConstraint& e : graph.edges()) {
    const Pose T_a_b = retract(e.T_a_b, noise(random, e));
    poses.push_back(e.a < e.b ? poses.back() * T_a_b : poses.back() * T_a_b.inverse());
  }
  return poses;
}

/// The largest deviation of a sampled covariance from the other, in units of the other.
double deviation(const Eigen::MatrixXd& sampled, const Eigen::MatrixXd& expected) {
  const Eigen::MatrixXd L = Eigen::LLT<Eigen::MatrixXd>(expected).matrixL();
  const Eigen::MatrixXd whitened = L.inverse() * sampled * L.inverse().transpose();
  return (whitened - Eigen::MatrixXd::Identity(whitened.rows(), whitened.cols())).cwiseAbs().maxCoeff();
}

Mat6 sampledCovariance(const KeyframeGraph& graph, KeyframeId id, int draws) {
  std::mt19937 random(1);
  Mat6 sum = Mat6::Zero();
  for (int k = 0; k < draws; ++k) {
    const Vec6 xi = localCoordinates(drawn(graph, random)[static_cast<std::size_t>(id)], poseOf(graph, id));
    sum += xi * xi.transpose();
  }
  return sum / draws;
}

TEST(CovariancesFrom, AreThoseOfDrawnChains) {
  const KeyframeGraph graph = chain(40);
  const auto covariances = covariancesFrom(graph, 0);
  EXPECT_EQ(covariances[0], Mat6::Zero());
  for (const KeyframeId id : {1, 7, 39}) {
    EXPECT_LT(deviation(sampledCovariance(graph, id, 20'000), covariances[static_cast<std::size_t>(id)]), 0.05) << id;
  }
}

TEST(CovariancesFrom, AConstraintThatIsGoneBackAlongSwingsItsStart) {
  KeyframeGraph graph;
  Pose T = Pose::Identity();
  T.translation() = Vec3(10, 2, 1);
  graph.add({0, Pose::Identity()});
  graph.add({1, T});
  graph.connect({1, 0, T.inverse(), 1, 1, false, kStep, kStepTurn});
  EXPECT_LT(deviation(sampledCovariance(graph, 1, 20'000), covariancesFrom(graph, 0)[1]), 0.05);
}

TEST(CovariancesFrom, TwoConstraintsBetweenTheSameKeyframesAreWorthTheBetterOne) {
  KeyframeGraph graph = chain(2);
  const Mat6 one = covariancesFrom(graph, 0)[1];
  BetweenConstraint twin = graph.edges()[0];
  graph.connect(twin);
  EXPECT_EQ(covariancesFrom(graph, 0)[1], one) << "they may share their errors";
  twin.expected /= 2;
  graph.connect(twin);
  EXPECT_LT(covariancesFrom(graph, 0)[1].trace(), one.trace());
}

TEST(CovarianceBetween, IsThatOfTheWholeSearch) {
  KeyframeGraph graph = chain(60);
  graph.connect({3, 50, poseOf(graph, 3).inverse() * poseOf(graph, 50), 1, 1, true, kStep, kStepTurn});
  const auto all = covariancesFrom(graph, 20);
  for (const KeyframeId to : {0, 19, 20, 45, 55}) {
    EXPECT_EQ(covarianceBetween(graph, 20, to), all[static_cast<std::size_t>(to)]) << to;
  }
}

TEST(CovarianceBetween, OfWhatNothingConnectsIsThatItCouldBeAnywhere) {
  KeyframeGraph graph;
  graph.add({0, Pose::Identity()});
  graph.add({1, Pose::Identity()});
  EXPECT_EQ(covarianceBetween(graph, 0, 1)(0, 0), square(kNotConnected));
}

PoseCovariances added(const KeyframeGraph& graph) {
  KeyframeGraph so_far;
  PoseCovariances covariances;
  for (const TimedPose& pose : graph.poses()) {
    const KeyframeId id = so_far.add(pose);
    for (const BetweenConstraint& e : graph.edgesOf(id)) {
      if (std::max(e.a, e.b) == id) {
        so_far.connect(e);
      }
    }
    covariances.add(so_far);
  }
  return covariances;
}

TEST(PoseCovariances, AddedOneByOneAreThoseOfAStoredMap) {
  KeyframeGraph graph = chain(50);
  graph.connect({5, 30, poseOf(graph, 5).inverse() * poseOf(graph, 30), 1, 1, false, kStep, kStepTurn});
  const PoseCovariances one_by_one = added(graph);
  PoseCovariances at_once;
  at_once.recompute(graph);
  for (KeyframeId id = 0; id <= graph.last(); ++id) {
    EXPECT_EQ(one_by_one.of(id), at_once.of(id)) << id;
  }
  EXPECT_EQ(at_once.of(-1), Mat6::Zero());
}

TEST(PoseCovariances, OnlyAClosedLoopMakesOlderKeyframesBetterKnown) {
  KeyframeGraph graph = chain(50);
  const PoseCovariances open = added(graph);
  const Pose T_0_49 = poseOf(graph, 49);
  for (const bool is_loop : {false, true}) {
    KeyframeGraph closed = graph;
    closed.connect({0, 49, T_0_49, 1, 1, is_loop, kStep, kStepTurn});
    PoseCovariances covariances;
    covariances.recompute(closed);
    EXPECT_LT(covariances.of(49).trace(), 0.5 * open.of(49).trace());
    if (is_loop) {
      EXPECT_LT(covariances.of(45).trace(), 0.5 * open.of(45).trace());
    } else {
      EXPECT_EQ(covariances.of(45), open.of(45)) << "it stays where it is";
    }
    EXPECT_EQ(covariances.of(5), open.of(5));
  }
}

/// Things anchored to keyframes of a chain, which the map holds.
Map mapWith(const KeyframeGraph& graph, const std::vector<std::pair<KeyframeId, Vec3>>& things) {
  std::vector<MapNode> nodes;
  for (const auto& [anchor, p_body] : things) {
    nodes.push_back(nodeAt(kCar, poseOf(graph, anchor) * p_body));
    nodes.back().id = static_cast<NodeId>(nodes.size());
    nodes.back().anchor = anchor;
  }
  return Map::restore(std::move(nodes), graph, {}, 1);
}

TEST(PositionCovarianceInMap, IsThatOfDrawnChainsAndOfTheThingItself) {
  const KeyframeGraph graph = chain(30);
  const Vec3 p_body(25, -10, 3);
  const Map map = mapWith(graph, {{29, p_body}});
  std::mt19937 random(2);
  Mat3 sampled = Mat3::Zero();
  constexpr int kDraws = 20'000;
  for (int k = 0; k < kDraws; ++k) {
    const Vec3 error = drawn(graph, random)[29] * p_body - poseOf(graph, 29) * p_body;
    sampled += error * error.transpose() / kDraws;
  }
  const MapNode& node = *map.find(1);
  const Mat3 drift = positionCovarianceInMap(map, node) - positionCovariance(node);
  EXPECT_LT(deviation(sampled, drift), 0.05);
}

TEST(PositionCovarianceInMap, IsTheLocalOneAtTheFirstKeyframeAndWithoutAnchor) {
  const Map map = mapWith(chain(3), {{0, Vec3(5, 5, 0)}, {2, Vec3(5, 5, 0)}});
  EXPECT_EQ(positionCovarianceInMap(map, *map.find(1)), positionCovariance(*map.find(1)));
  MapNode loose = *map.find(2);
  EXPECT_GT(positionCovarianceInMap(map, loose).trace(), positionCovariance(loose).trace());
  loose.anchor = -1;
  EXPECT_EQ(positionCovarianceInMap(map, loose), positionCovariance(loose));
}

TEST(RelativeCovariance, IsThatOfDrawnChains) {
  const KeyframeGraph graph = chain(40);
  const Vec3 p_a(10, 4, 1), p_b(-3, 8, 0);
  const Map map = mapWith(graph, {{30, p_a}, {38, p_b}});
  const auto apart = [&](const std::vector<Pose>& poses) { return Vec3(poses[38] * p_b - poses[30] * p_a); };
  std::vector<Pose> known;
  for (const TimedPose& pose : graph.poses()) {
    known.push_back(pose.T_map_body);
  }
  std::mt19937 random(3);
  Mat3 sampled = Mat3::Zero();
  constexpr int kDraws = 20'000;
  for (int k = 0; k < kDraws; ++k) {
    const Vec3 error = apart(drawn(graph, random)) - apart(known);
    sampled += error * error.transpose() / kDraws;
  }
  const MapNode &a = *map.find(1), &b = *map.find(2);
  const Mat3 own = positionCovariance(a) + positionCovariance(b);
  EXPECT_LT(deviation(sampled, relativeCovariance(map, a, b) - own), 0.05);
  EXPECT_EQ(relativeCovariance(map, a, b), relativeCovariance(map, b, a));
  EXPECT_TRUE(relativeCovariance(map, a, b, covariancesFrom(graph, 30)).isApprox(relativeCovariance(map, a, b), 1e-12));
}

TEST(RelativeCovariance, OfNeighboursFarFromTheStartIsSmallerThanWhereTheyAre) {
  const Map map = mapWith(chain(200), {{198, Vec3(1, 2, 0)}, {199, Vec3(1, -2, 0)}, {199, Vec3(2, 0, 0)}});
  const MapNode &a = *map.find(1), &b = *map.find(2), &c = *map.find(3);
  EXPECT_LT(relativeCovariance(map, a, b).trace(), 0.1 * positionCovarianceInMap(map, b).trace());
  const Mat3 own = positionCovariance(b) + positionCovariance(c);
  EXPECT_GE((relativeCovariance(map, b, c) - own).trace(), 0) << "the turn of their neighbourhood";
}

}  // namespace
}  // namespace hgg::drift_test
