#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstring>
#include <set>

#include "map/file.h"
#include "map/map.h"
#include "map/test_map.h"

namespace hgg::map_correction_test {
namespace {

constexpr ClassId kCar = 10, kRoad = 40;
constexpr double kTileSize = 10;

Pose at(double x, double y = 0, double yaw_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw_deg * M_PI / 180, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = Vec3(x, y, 0);
  return T;
}

/// A new keyframe at `T` with a constraint to the last one, and what it makes.
MapUpdate keyframeAt(const Map& map, const Pose& T, std::vector<MapNode> created, double sigma = 0.02) {
  MapUpdate update;
  update.keyframe = NewKeyframe{{1000 * (map.keyframes().last() + 1), T}, {}};
  if (map.keyframes().last() >= 0) {
    const Pose T_last_body = map.keyframes().poses().back().T_map_body.inverse() * T;
    update.keyframe->constraints = {{map.keyframes().last(), -1, T_last_body, sigma, 0.04 * M_PI / 180, false}};
  }
  update.created = std::move(created);
  return update;
}

/// A drive along x, a keyframe every 5 m, a car and a road node beside each.
Map drive(int keyframes, double reach = std::numeric_limits<double>::infinity(), double sigma = 0.02) {
  std::mt19937 random(7);
  Map map;
  map.setTileSize(kTileSize);
  map.setDriftReach(reach);
  for (int k = 0; k < keyframes; ++k) {
    MapNode car = nodeAt(kCar, Vec3(5 * k, 4, 0));
    car.geometry = shareLeaves(Leaves(3, randomLeaf(random)));
    const Vec3 road(5 * k, -1, 0);
    map.apply(keyframeAt(map, at(5 * k), {car, tileNode(kRoad, tileOf(road, kTileSize), road)}, sigma));
  }
  return map;
}

MapCorrection moveOf(KeyframeId id, const Pose& T_map_body) { return {{{id, T_map_body}}, {}}; }

bool sameLeaves(const MapNode& a, const MapNode& b) {
  return leavesOf(a).size() == leavesOf(b).size() &&
         (leavesOf(a).empty() ||
          std::memcmp(leavesOf(a).data(), leavesOf(b).data(), leavesOf(a).size() * sizeof(Leaf)) == 0);
}

std::vector<NodeId> anchoredTo(const Map& map, KeyframeId id) {
  std::vector<NodeId> ids;
  for (const auto& [node_id, node] : map.nodes()) {
    if (node.anchor == id) {
      ids.push_back(node_id);
    }
  }
  return ids;
}

/// All that a map can be asked about places, asked of every node one by one.
void expectAnswersLikeBruteForce(const Map& map, std::mt19937& random) {
  const auto collect = [&](const auto& admits) {
    std::vector<NodeId> ids;
    for (const auto& [id, node] : map.nodes()) {
      if (admits(node)) {
        ids.push_back(id);
      }
    }
    return ids;
  };
  for (const double radius : {0.0, 6.0, 30.0, 500.0}) {
    const Vec3 centre = randomVector(random, 70);
    const auto isNear = [&](const MapNode& n) { return (n.belief.mean - centre).norm() <= radius; };
    EXPECT_EQ(map.nearAnywhere(centre, radius), collect(isNear));
    EXPECT_EQ(map.near(centre, radius), collect([&](const MapNode& n) { return isNear(n) && map.isActive(n); }));
  }
  std::set<std::pair<ClassId, Tile>> tiles{{kRoad, {77, 77, 0}}};
  for (const auto& [id, node] : map.nodes()) {
    tiles.emplace(node.label, node.tile);
  }
  for (const auto& [label, tile] : tiles) {
    const auto ids = collect([&, label = label, tile = tile](const MapNode& n) {
      return n.stuff && n.label == label && n.tile == tile && map.isActive(n);
    });
    EXPECT_EQ(map.activeOfTile(label, tile), ids);
    EXPECT_EQ(map.findTile(label, tile), ids.empty() ? nullptr : map.find(ids.front()));
  }
}

TEST(MapCorrection, ANodeMovesExactlyWithItsAnchorAndTheOthersStay) {
  std::mt19937 random(1);
  Map map = drive(6);
  const Map before = map;
  const Pose T = at(11, 3, 25);
  const MapDelta delta = map.apply(moveOf(2, T));
  const Pose move = T * before.keyframes().poses()[2].T_map_body.inverse();
  EXPECT_EQ(delta.revision, before.revision());
  EXPECT_EQ(delta.moved, anchoredTo(before, 2));
  EXPECT_TRUE(delta.changed.empty());
  EXPECT_TRUE(delta.removed.empty());
  for (const auto& [id, node] : map.nodes()) {
    const MapNode& was = *before.find(id);
    EXPECT_TRUE(sameLeaves(node, was)) << id;
    EXPECT_EQ(node.anchor, was.anchor);
    if (node.anchor != 2) {
      EXPECT_EQ(node.belief.mean, was.belief.mean);
      EXPECT_EQ(node.belief.cov, was.belief.cov);
      EXPECT_EQ(node.tile, was.tile);
      continue;
    }
    const Belief expected = transform(move, was.belief);
    EXPECT_EQ(node.belief.mean, expected.mean);
    EXPECT_EQ(node.belief.cov, expected.cov);
    EXPECT_EQ(node.belief.kappa, was.belief.kappa);
    EXPECT_EQ(node.T_map_object.matrix(), (move * was.T_map_object).matrix());
    // As seen from the anchor nothing has moved.
    EXPECT_TRUE((T.inverse() * node.T_map_object)
                    .isApprox(before.keyframes().poses()[2].T_map_body.inverse() * was.T_map_object, 1e-12));
  }
  EXPECT_EQ(map.keyframes().poses()[2].T_map_body.matrix(), T.matrix());
  EXPECT_EQ(map.keyframes().poses()[2].utime_us, before.keyframes().poses()[2].utime_us);
  expectAnswersLikeBruteForce(map, random);
}

TEST(MapCorrection, ATileIsNamedByWhereItsMeanHasComeToLie) {
  Map map = drive(4);
  const NodeId road = anchoredTo(map, 1)[1];
  map.apply(moveOf(1, at(48, 33)));
  const MapNode& node = *map.find(road);
  EXPECT_EQ(node.tile, tileOf(node.belief.mean, kTileSize));
  EXPECT_EQ(node.tile, (Tile{5, 3, 0}));
  EXPECT_EQ(map.findTile(kRoad, {5, 3, 0}), &node);
  const NodeId car = anchoredTo(map, 1)[0];
  EXPECT_EQ(map.find(car)->tile, Tile{});  // a thing lives in no tile
}

TEST(MapCorrection, ToWhereKeyframesAreChangesNoByte) {
  for (Map map : {drive(6), drive(30, 0.1)}) {
    const std::string before = encodeMap(map);
    MapCorrection correction;
    for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
      correction.moved.emplace_back(k, map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body);
    }
    const MapDelta delta = map.apply(correction);
    EXPECT_TRUE(delta.moved.empty());
    EXPECT_TRUE(delta.reactivated.empty());
    EXPECT_EQ(encodeMap(map), before);
  }
}

TEST(MapCorrection, OfAMapWithoutKeyframesDoesNothing) {
  Map map;
  map.setDriftReach(0.5);
  EXPECT_EQ(map.apply(MapCorrection{}).revision, 0);
}

/// The solvers' poses are rigid; what a map multiplies together from thousands of them has to stay so.
TEST(MapCorrection, NodesStayRigidThroughThousandsOfSmallMoves) {
  std::mt19937 random(5);
  Map map = drive(4);
  for (int step = 0; step < 2000; ++step) {
    MapCorrection correction;
    for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
      const Pose& T = map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body;
      const Vec3 turn = randomVector(random, 0.01);
      const Eigen::AngleAxisd by(turn.norm(), turn.normalized());
      Pose moved = Pose::Identity();
      moved.linear() = Eigen::Quaterniond(by * T.linear()).normalized().toRotationMatrix();
      moved.translation() = T.translation() + randomVector(random, 0.01);
      correction.moved.emplace_back(k, moved);
    }
    map.apply(correction);
  }
  for (const auto& [id, node] : map.nodes()) {
    const Mat3 R = node.T_map_object.linear();
    EXPECT_LE((R.transpose() * R - Mat3::Identity()).norm(), 1e-9) << id;
    EXPECT_NEAR(R.determinant(), 1, 1e-9) << id;
    EXPECT_LE(relativeError(node.belief.cov, node.stuff ? Mat3(4 * Mat3::Identity()) : Mat3(0.25 * Mat3::Identity())),
              1e-9)
        << id;
    const Pose& T = map.keyframes().poses()[static_cast<std::size_t>(node.anchor)].T_map_body;
    const Vec3 seen(0, node.stuff ? -1 : 4, 0);
    EXPECT_LE((T.inverse() * node.belief.mean - seen).norm(), 1e-9) << id;
    EXPECT_LE((T.inverse() * node.T_map_object.translation() - seen).norm(), 1e-9) << id;
  }
}

TEST(MapReach, WhatMayHaveDriftedFarIsInvisibleToFramesOnly) {
  std::mt19937 random(2);
  const Map map = drive(30, 0.1);
  const std::vector<Drift> drift = map.keyframes().driftFrom(map.keyframes().last(), 0.1);
  std::size_t active = 0;
  for (const auto& [id, node] : map.nodes()) {
    EXPECT_EQ(map.isActive(node), drift[static_cast<std::size_t>(node.anchor)].position >= 0) << id;
    active += map.isActive(node) ? 1 : 0;
  }
  EXPECT_GT(active, 6U);
  EXPECT_LT(active, 40U);
  EXPECT_EQ(map.nearAnywhere(Vec3(0, 4, 0), 1).size(), 1U);
  EXPECT_TRUE(map.near(Vec3(0, 4, 0), 1).empty());
  EXPECT_EQ(map.near(Vec3(145, 4, 0), 1).size(), 1U);
  EXPECT_EQ(map.findTile(kRoad, {0, 0, 0}), nullptr);
  EXPECT_TRUE(map.activeOfTile(kRoad, {0, 0, 0}).empty());
  expectAnswersLikeBruteForce(map, random);
}

TEST(MapReach, OfWhatLiesInATileTheOldestActiveIsFound) {
  Map map = drive(30, 0.1);
  const Vec3 p(2, -1, 0);
  map.apply(keyframeAt(map, at(0), {tileNode(kRoad, {0, 0, 0}, p), tileNode(kRoad, {0, 0, 0}, p)}));
  const NodeId newest = map.nextId() - 1;
  EXPECT_EQ(map.findTile(kRoad, {0, 0, 0})->id, newest - 1);
  EXPECT_EQ(map.activeOfTile(kRoad, {0, 0, 0}), (std::vector<NodeId>{newest - 1, newest}));
}

TEST(MapReach, ALoopWakesExactlyTheNodesThatItBringsWithinReach) {
  Map map = drive(30, 0.1);
  const Map before = map;
  const KeyframeId last = map.keyframes().last();
  const MapDelta delta = map.apply(MapCorrection{{}, {{2, last, at(1), 0.03, 0.001, true}}});
  const std::vector<Drift> drift = map.keyframes().driftFrom(last, 0.1);
  std::vector<NodeId> reactivated;
  for (const auto& [id, node] : map.nodes()) {
    const bool reached = drift[static_cast<std::size_t>(node.anchor)].position >= 0;
    EXPECT_EQ(map.isActive(node), reached);
    if (reached && !before.isActive(*before.find(id))) {
      reactivated.push_back(id);
    }
  }
  EXPECT_EQ(delta.reactivated, reactivated);
  EXPECT_TRUE(std::ranges::includes(reactivated, anchoredTo(map, 2)));
  EXPECT_TRUE(delta.moved.empty());
}

TEST(MapReach, AConstraintOfANewKeyframeWakesTooButNotWhatTheSameUpdateTakesAway) {
  Map map = drive(30, 0.1);
  MapUpdate update = keyframeAt(map, at(150), {nodeAt(kCar, Vec3(150, 4, 0))});
  update.keyframe->constraints.push_back({2, -1, at(140), 0.03, 0.001, false});
  const std::vector<NodeId> there = anchoredTo(map, 2);
  update.removed = {there[0]};
  const MapDelta delta = map.apply(std::move(update));
  EXPECT_FALSE(std::ranges::binary_search(delta.reactivated, there[0]));
  EXPECT_TRUE(std::ranges::binary_search(delta.reactivated, there[1]));
  EXPECT_FALSE(std::ranges::binary_search(delta.reactivated, map.nextId() - 1));  // was never asleep
  EXPECT_EQ(map.keyframes().edges().back().b, map.keyframes().last());
  for (const NodeId id : delta.reactivated) {
    ASSERT_NE(map.find(id), nullptr);
  }
}

TEST(MapReach, NodesWithoutAnAnchorAreAlwaysActive) {
  const Map driven = drive(30);
  std::vector<MapNode> nodes;
  for (const auto& [id, node] : driven.nodes()) {
    nodes.push_back(node);
    nodes.back().anchor = id <= 2 ? -1 : node.anchor;
  }
  Map map = Map::restore(nodes, driven.keyframes(), {}, 1);
  map.setDriftReach(0.1);
  map.apply(keyframeAt(map, at(150), {}));
  EXPECT_TRUE(map.isActive(*map.find(1)));
  EXPECT_TRUE(map.isActive(*map.find(2)));
  EXPECT_FALSE(map.isActive(*map.find(3)));
  MapCorrection everything;
  for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
    everything.moved.emplace_back(k, at(5.0 * k, 8));
  }
  map.apply(everything);
  EXPECT_EQ(map.find(1)->belief.mean, driven.find(1)->belief.mean);
  EXPECT_NEAR(map.find(3)->belief.mean.y(), driven.find(3)->belief.mean.y() + 8, 1e-9);
}

TEST(MapReach, AStoredMapIsActiveAsAWholeUntilANewKeyframe) {
  const Map driven = drive(30, 0.1);
  auto stored = decodeMap(encodeMap(driven));
  ASSERT_TRUE(stored) << stored.error;
  Map map = std::move(stored->map);
  map.setDriftReach(0.1);
  for (const auto& [id, node] : map.nodes()) {
    EXPECT_TRUE(map.isActive(node));
  }
  map.apply(keyframeAt(map, at(150), {}));
  EXPECT_FALSE(map.isActive(*map.find(1)));
}

/// What the map has to hold after any sequence of updates and corrections.
struct Model {
  std::map<NodeId, MapNode> nodes;
  std::vector<Pose> keyframes;

  void apply(const MapCorrection& correction) {
    for (const auto& [id, T] : correction.moved) {
      const Pose move = T * keyframes[static_cast<std::size_t>(id)].inverse();
      for (auto& [node_id, node] : nodes) {
        if (node.anchor == id) {
          node.belief = transform(move, node.belief);
          node.T_map_object = move * node.T_map_object;
          node.tile = node.stuff ? tileOf(node.belief.mean, kTileSize) : node.tile;
        }
      }
      keyframes[static_cast<std::size_t>(id)] = T;
    }
  }
  void expectIn(const Map& map) const {
    ASSERT_EQ(map.nodes().size(), nodes.size());
    for (const auto& [id, node] : nodes) {
      const MapNode* found = map.find(id);
      ASSERT_NE(found, nullptr);
      EXPECT_LE((found->belief.mean - node.belief.mean).norm(), 1e-9);
      EXPECT_TRUE(found->T_map_object.isApprox(node.T_map_object, 1e-9));
      EXPECT_EQ(found->tile, node.tile);
      EXPECT_EQ(found->anchor, node.anchor);
      EXPECT_TRUE(sameLeaves(*found, node));
    }
  }
};

MapUpdate randomUpdate(std::mt19937& random, const Map& map) {
  const Vec3 t = randomVector(random, 40);
  MapUpdate update = keyframeAt(map, at(t.x(), t.y(), 10 * t.z()), {}, uniform(random, 0.01, 0.2));
  if (below(random, 4) == 0 && map.keyframes().last() > 0) {
    const auto old = static_cast<KeyframeId>(below(random, static_cast<std::uint32_t>(map.keyframes().last())));
    update.keyframe->constraints.push_back({old, -1, at(2), 0.05, 0.002, false});
  }
  for (std::uint32_t n = below(random, 6); n > 0; --n) {
    const Vec3 p = randomVector(random, 60);
    update.created.push_back(below(random, 2) == 0 ? randomNode(random, 60) : tileNode(kRoad, tileOf(p, kTileSize), p));
  }
  for (const auto& [id, node] : map.nodes()) {
    if (const std::uint32_t fate = below(random, 20); fate == 0) {
      update.removed.push_back(id);
    } else if (fate <= 2) {
      update.changed.push_back(node);
      update.changed.back().belief.mean += randomVector(random, 1);
    }
  }
  return update;
}

TEST(MapCorrection, RandomSequencesAgreeWithAModelThatLooksAtEveryNode) {
  std::mt19937 random(3);
  Map map;
  map.setTileSize(kTileSize);
  map.setDriftReach(0.3);
  Model model;
  for (int step = 0; step < 150; ++step) {
    if (step > 2 && below(random, 3) == 0) {
      MapCorrection correction;
      for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
        if (below(random, 3) == 0) {
          const Vec3 t = randomVector(random, 5);
          const Pose& T = map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body;
          correction.moved.emplace_back(k, at(t.x(), t.y(), t.z()) * T);
        }
      }
      if (below(random, 2) == 0) {
        correction.loops.push_back({0, map.keyframes().last(), at(1), 0.05, 0.002, true});
      }
      model.apply(correction);
      map.apply(correction);
    } else {
      MapUpdate update = randomUpdate(random, map);
      const std::vector<NodeId> removed = update.removed;
      const MapDelta delta = map.apply(std::move(update));
      if (map.keyframes().poses().size() > model.keyframes.size()) {
        model.keyframes.push_back(map.keyframes().poses().back().T_map_body);
      }
      for (const NodeId id : removed) {
        model.nodes.erase(id);
      }
      for (const NodeId id : delta.changed) {
        model.nodes[id] = *map.find(id);
      }
    }
    model.expectIn(map);
    expectAnswersLikeBruteForce(map, random);
    if (HasFailure()) {
      FAIL() << "at step " << step;
    }
  }
  EXPECT_GT(map.nodes().size(), 20U);
}

TEST(PositionCovariance, ShrinksWithViewsDownToItsFloor) {
  std::mt19937 random(4);
  for (int run = 0; run < 50; ++run) {
    MapNode node = randomNode(random, 20);
    node.belief.kappa = 1e5;
    Mat3 before = Mat3::Constant(std::numeric_limits<double>::infinity());
    for (const int views : {1, 2, 5, 20, 1000, 1'000'000}) {
      node.views = views;
      const Mat3 cov = positionCovariance(node);
      EXPECT_LT(cov.trace(), before.trace()) << views;
      EXPECT_TRUE(cov.isApprox(cov.transpose(), 1e-12));
      const Mat3 above = cov - 0.06 * 0.06 * node.belief.cov - 0.02 * 0.02 * Mat3::Identity();
      EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(above).eigenvalues()[0], 0) << views;
      before = cov;
    }
  }
}

TEST(PositionCovariance, OfANodeIsThatOfItsDrive) {
  std::mt19937 random(5);
  for (int run = 0; run < 50; ++run) {
    MapNode node = randomNode(random, 20);
    node.belief.kappa = 1 + run;
    node.views = 1 + run / 10;
    const double views = node.views;
    const double share = 1 / node.belief.kappa + 0.7 * 0.7 / views + 0.06 * 0.06;
    const Mat3 expected = share * node.belief.cov + (0.05 * 0.05 / views + 0.02 * 0.02) * Mat3::Identity();
    EXPECT_EQ(positionCovariance(node), expected);
  }
}

TEST(PositionCovariance, OfNoViewsAndNoEvidenceIsFiniteAndNotSmallerThanOfOne) {
  MapNode node = nodeAt(kCar, Vec3(1, 2, 3), 0.5, 0);
  node.views = 0;
  const Mat3 none = positionCovariance(node);
  EXPECT_TRUE(none.allFinite());
  node.views = 1, node.belief.kappa = 1;
  EXPECT_TRUE(none.isApprox(positionCovariance(node), 1e-15));
  node.belief.cov.setZero();
  EXPECT_GE(positionCovariance(node).diagonal().minCoeff(), 0.02 * 0.02);
}

}  // namespace
}  // namespace hgg::map_correction_test
