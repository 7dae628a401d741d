#include "correction/corrector.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "map/file.h"
#include "map/test_map.h"
#include "test_scene.h"

namespace hgg::corrector_test {
namespace {

Pose at(double x, double y = 0) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, y, 0);
  return T;
}

Alignment alignedAt(const Pose& T_map_body) {
  Alignment alignment;
  alignment.pose.T_map_body = T_map_body;
  return alignment;
}

LocalGraph frameAt(Micros utime_us) {
  LocalGraph local;
  local.utime_us = utime_us;
  return local;
}

Config everythingOn() {
  Config config;
  config.correction.window = config.correction.em = config.correction.loop_closure = true;
  return config;
}

Corrector correctorOf(const Config& config) { return {config, testClasses(), LoopTiming::kFixed}; }

void addKeyframe(Map& map, const std::optional<NewKeyframe>& keyframe) {
  MapUpdate update;
  update.keyframe = keyframe;
  map.apply(std::move(update));
}

TEST(DecideKeyframe, IsForTheFirstFrameAndThenForOneThatIsTwoMetresOn) {
  Map map;
  Corrector corrector = correctorOf({});
  const auto first = corrector.decideKeyframe(map, frameAt(7), alignedAt(at(5)), Pose::Identity(), true, {}).added;
  ASSERT_TRUE(first);
  EXPECT_EQ(first->pose.utime_us, 7);
  EXPECT_EQ(first->pose.T_map_body.matrix(), at(5).matrix());
  EXPECT_TRUE(first->constraints.empty());
  addKeyframe(map, first);
  EXPECT_FALSE(corrector.decideKeyframe(map, frameAt(8), alignedAt(at(6.5)), at(1.5), false, {}).added);
  EXPECT_TRUE(corrector.decideKeyframe(map, frameAt(9), alignedAt(at(7.5)), at(1), false, {}).added);
}

TEST(DecideKeyframe, OneThatIsMetAgainIsTakenUpInsteadOfANewOne) {
  Map map;
  Corrector corrector = correctorOf({});
  for (int k = 0; k < 5; ++k) {
    addKeyframe(map, corrector.decideKeyframe(map, frameAt(k), alignedAt(at(2.1 * k)), at(2.1), false, {}).added);
  }
  Alignment alignment = alignedAt(at(2.3));
  alignment.leaf_pairs = 50;
  EXPECT_EQ(corrector.decideKeyframe(map, frameAt(9), alignment, at(-6), false, {}).taken_up, 1);
  MapUpdate update;
  update.taken_up = 1;
  update.created.push_back(nodeAt(kPole, Vec3(2, 3, 0)));
  map.apply(std::move(update));
  EXPECT_EQ(map.keyframes().current(), 1);
  EXPECT_EQ(map.nodes().begin()->second.anchor, 1);
  alignment.pose.T_map_body = at(12.5);
  const KeyframeDecision beyond = corrector.decideKeyframe(map, frameAt(10), alignment, at(10), false, {});
  ASSERT_TRUE(beyond.added);
  EXPECT_EQ(beyond.added->constraints.front().a, 1) << "from the one the robot was at";
}

TEST(DecideKeyframe, ItsConstraintHasTheUncertaintyOfAllFramesSinceTheLastKeyframeAndOfNoOther) {
  Map map;
  Corrector corrector = correctorOf({});
  addKeyframe(map, corrector.decideKeyframe(map, frameAt(0), alignedAt(at(0)), Pose::Identity(), false, {}).added);
  for (const double start : {0.0, 2.4}) {
    Travel travel;
    std::optional<NewKeyframe> keyframe;
    for (const double x : {1.5, 2.4}) {
      EXPECT_FALSE(keyframe);
      const Pose step = at(x == 1.5 ? 1.5 : 0.9);
      const Alignment alignment = alignedAt(at(start + x));
      travel = propagateTravel(travel, step, alignment, false, AlignmentConfig{}, MapConfig{}.leaf_size);
      keyframe = corrector.decideKeyframe(map, frameAt(1), alignment, step, false, {}).added;
    }
    ASSERT_TRUE(keyframe);
    ASSERT_EQ(keyframe->constraints.size(), 1U);
    EXPECT_EQ(keyframe->constraints[0].a, map.keyframes().last());
    EXPECT_EQ(keyframe->constraints[0].sigma, travel.sigma);
    EXPECT_EQ(keyframe->constraints[0].sigma_turn, travel.sigma_turn);
    EXPECT_GT(travel.sigma, 0);
    addKeyframe(map, keyframe);
  }
}

TEST(Corrector, WithoutAKeyframeDoesNothing) {
  Corrector corrector = correctorOf(everythingOn());
  Map map = mapOf({nodeAt(kCar, Vec3(0, 4, 0)), nodeAt(kCar, Vec3(0, 4.1, 0))});
  const std::string before = encodeMap(map);
  MapDelta updated;
  updated.revision = map.revision();
  updated.changed = {2};
  LocalGraph local;
  local.objects.resize(1);
  Alignment alignment = alignedAt(at(50));  // however far the robot has gone
  alignment.pose.information = 3 * Mat6::Identity();
  alignment.pairs = {{0, 1, 0}};
  const Correction correction = corrector.correct(map, updated, {}, local, alignment);
  EXPECT_EQ(encodeMap(map), before);
  EXPECT_EQ(correction.delta.revision, updated.revision);
  EXPECT_EQ(correction.delta.changed, updated.changed);
  EXPECT_TRUE(correction.delta.moved.empty());
  EXPECT_TRUE(correction.delta.removed.empty());
  EXPECT_EQ(correction.pose.T_map_body.matrix(), alignment.pose.T_map_body.matrix());
  EXPECT_EQ(correction.pose.information, alignment.pose.information);
  EXPECT_TRUE(corrector.loops().records().empty());
}

/// A map of road tiles, each of which two nodes lie in, and a delta that says so: the second of two has been
/// reactivated.
struct DoubledTiles {
  Map map;
  MapDelta updated;

  explicit DoubledTiles(int tiles) {
    std::vector<MapNode> nodes;
    for (int copy = 0; copy < 2; ++copy) {
      for (int k = 0; k < tiles; ++k) {
        const Vec3 mean(10 * k, 0, 0);
        nodes.push_back(tileNode(kRoad, tileOf(mean, 10), mean));
      }
    }
    map = mapOf(std::move(nodes));
    map.setTileSize(10);
    updated.revision = map.revision();
    for (NodeId id = tiles + 1; id <= 2 * tiles; ++id) {
      updated.reactivated.push_back(id);
    }
  }
};

TEST(Corrector, PendingMergesAreWorkedOffTwoHundredAFrame) {
  DoubledTiles doubled(450);
  Corrector corrector = correctorOf(everythingOn());
  MapDelta updated = doubled.updated;
  for (const std::size_t merged : {200U, 200U, 50U, 0U}) {
    const std::size_t before = doubled.map.nodes().size();
    const Correction correction = corrector.correct(doubled.map, updated, {}, {}, {});
    EXPECT_EQ(before - doubled.map.nodes().size(), merged);
    EXPECT_EQ(correction.delta.removed.size(), merged);
    EXPECT_EQ(correction.delta.revision, doubled.map.revision());
    updated.reactivated.clear();
  }
  for (const auto& [id, node] : doubled.map.nodes()) {
    EXPECT_EQ(node.belief.kappa, 200) << id;
  }
}

TEST(Corrector, FinishWorksOffAllPendingMerges) {
  DoubledTiles doubled(450);
  Corrector corrector = correctorOf({});
  corrector.correct(doubled.map, doubled.updated, {}, {}, {});
  ASSERT_EQ(doubled.map.nodes().size(), 700U);
  const Correction correction = corrector.finish(doubled.map, {at(3), Mat6::Identity()});
  EXPECT_EQ(doubled.map.nodes().size(), 450U);
  EXPECT_EQ(correction.delta.removed.size(), 250U);
  EXPECT_EQ(correction.pose.T_map_body.matrix(), at(3).matrix());
}

/// A robot that sees poles of a known map as they are, while its odometry slides 10 cm to the side at every keyframe.
TEST(Corrector, ThePoseOfTheFrameMovesRigidlyWithItsKeyframe) {
  std::mt19937 random(1);
  std::vector<MapNode> poles;
  for (NodeId id = 1; id <= 12; ++id) {
    poles.push_back(nodeAt(kPole, Vec3(4, 0, 0) + randomVector(random, 10), 0.1, 1e4));
    poles.back().id = id;
  }
  Map map = Map::restore(poles, {}, {}, 1);
  Corrector corrector = correctorOf(everythingOn());
  const Pose T_keyframe_body = at(0.3, 0.1);  // of the pose that is corrected
  for (int k = 0; k < 5; ++k) {
    Alignment alignment = alignedAt(k == 0 ? at(0) : Pose(map.keyframes().poses().back().T_map_body * at(2.1, 0.1)));
    LocalGraph local = frameAt(k);
    for (const MapNode& pole : poles) {
      LocalObject object;
      object.label = kPole;
      object.belief = transform(at(2.1 * k).inverse(), pole.belief);
      object.belief.kappa = 200;
      alignment.pairs.push_back({static_cast<int>(local.objects.size()), pole.id, 0});
      local.objects.push_back(object);
    }
    const auto keyframe = corrector.decideKeyframe(map, local, alignment, at(2.1, 0.1), false, {}).added;
    ASSERT_TRUE(keyframe);
    MapUpdate update;
    update.keyframe = keyframe;
    MapDelta updated = map.apply(std::move(update));
    alignment.pose.T_map_body = alignment.pose.T_map_body * T_keyframe_body;
    const Pose before = alignment.pose.T_map_body;
    const Correction correction = corrector.correct(map, std::move(updated), {keyframe, -1}, local, alignment);
    const Pose& T_map_keyframe = map.keyframes().poses().back().T_map_body;
    EXPECT_LE(localCoordinates(T_map_keyframe.inverse() * correction.pose.T_map_body, T_keyframe_body).norm(), 1e-9);
    EXPECT_EQ((correction.pose.T_map_body.translation() - before.translation()).norm() > 0.03, k > 0) << k;
    EXPECT_LT(std::abs(T_map_keyframe.translation().y()), 0.1) << k;
  }
}

}  // namespace
}  // namespace hgg::corrector_test
