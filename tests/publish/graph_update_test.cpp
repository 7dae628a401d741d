#include "publish/graph_update.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "publish/health.h"
#include "small_world.h"

namespace hgg::graph_update_test {
namespace {

/// A mapper that has driven through the small world, and what it published on the way.
struct Drive {
  Mapper mapper{Config{}, ClassTable::builtin()};
  std::vector<GraphUpdate> updates;

  explicit Drive(int frames) {
    for (int i = 0; i < frames; ++i) {
      const auto odometry = SmallWorld::odometry(i);
      const auto report = mapper.step({odometry.utime_us, odometry.T_odom_body, SmallWorld::points(i)});
      updates.push_back(changedGraph(mapper, report));
    }
  }
};

TEST(Publish, UpdatesAddUpToTheCompleteGraph) {
  const Drive drive(40);
  std::map<NodeId, ObjectSummary> followed;
  for (const auto& update : drive.updates) {
    EXPECT_FALSE(update.complete);
    for (const auto& object : update.objects) {
      followed[object.id] = object;
    }
    for (const NodeId id : update.removed) {
      followed.erase(id);
    }
  }
  const auto complete = completeGraph(drive.mapper, 5);
  EXPECT_TRUE(complete.complete);
  EXPECT_EQ(complete.utime_us, 5);
  ASSERT_GT(complete.objects.size(), 10u);
  ASSERT_EQ(complete.objects.size(), followed.size());
  for (const auto& object : complete.objects) {
    const auto& other = followed.at(object.id);
    EXPECT_EQ(object.belief.mean, other.belief.mean);
    EXPECT_EQ(object.belief.kappa, other.belief.kappa);
    EXPECT_EQ(object.views, other.views);
    EXPECT_EQ(object.leaves, other.leaves);
    EXPECT_EQ(object.name, other.name);
  }
}

TEST(Publish, AThingInDoubtIsRemovedAndOneBelievedInSaysHowMuch) {
  Config config;
  MapNode sure, doubted;
  sure.id = 1, doubted.id = 2;
  sure.label = doubted.label = 10;
  sure.belief = doubted.belief = {Vec3(1, 2, 3), Mat3::Identity(), 400};
  addViews(sure.classes, {{10, 60.0F}, {18, 20.0F}});
  addViews(doubted.classes, {{10, 1.0F}, {40, 30.0F}});
  Map map = Map::restore({sure, doubted}, {}, {}, 3);
  map.setTileSize(config.creation.tile_size);
  const Mapper mapper(config, ClassTable::builtin(), std::move(map));
  StepReport report;
  report.delta.changed = {1, 2};
  const GraphUpdate update = changedGraph(mapper, report);
  ASSERT_EQ(update.objects.size(), 1U);
  EXPECT_EQ(update.objects[0].id, 1);
  EXPECT_DOUBLE_EQ(update.objects[0].class_probability, 0.75);
  EXPECT_DOUBLE_EQ(update.objects[0].existence, existence(sure.classes, 10, 400));
  EXPECT_EQ(update.removed, (std::vector<NodeId>{2}));
  EXPECT_EQ(completeGraph(mapper, 0).objects.size(), 1U);
}

constexpr double kDrift = 0.1;  // m, from one keyframe to the next

KeyframeGraph keyframesAtRest(int count) {
  KeyframeGraph keyframes;
  for (int k = 0; k < count; ++k) {
    keyframes.add({k, Pose::Identity()});
    if (k > 0) {
      keyframes.connect({k - 1, k, Pose::Identity(), 0.3, 0.1, false, kDrift, 1e-6});
    }
  }
  return keyframes;
}

Mapper mapperOf(std::vector<MapNode> nodes, KeyframeGraph keyframes = {}) {
  const Config config;
  Map map = Map::restore(std::move(nodes), std::move(keyframes), {}, 3);
  map.setTileSize(config.creation.tile_size);
  return {config, ClassTable::builtin(), std::move(map)};
}

TEST(Publish, AThingSaysWhatItsPlaceWasTakenForAndHowWellItIsKnown) {
  MapNode car;
  car.id = 1, car.label = 10;
  car.belief = {Vec3(1, 2, 3), Vec3(4, 1, 0.25).asDiagonal(), 400};
  car.views = 80;
  car.anchor = 1;
  addViews(car.classes, {{10, 60.0F}, {18, 20.0F}});
  const Mapper mapper = mapperOf({car}, keyframesAtRest(2));
  const auto sent = completeGraph(mapper, 0).objects.at(0);
  EXPECT_EQ(sent.classes, (ClassWeights{{10, 0.75F}, {18, 0.25F}}));
  EXPECT_EQ(sent.anchor, 1);
  // 1 / n_eff = 1/400 + 0.7^2/80 + 0.06^2 = 0.012225 of the extent, and (5 cm)^2 / 80 + (2 cm)^2.
  const Vec3 variance = 0.012225 * Vec3(4, 1, 0.25) + Vec3::Constant(0.00043125);
  const Vec3 in_map = variance + Vec3::Constant(kDrift * kDrift);
  EXPECT_TRUE(sent.position_cov.isApprox(Mat3(in_map.asDiagonal()), 1e-6)) << sent.position_cov;
  EXPECT_TRUE(sent.relative_cov.isApprox(Mat3(variance.asDiagonal()), 1e-12)) << sent.relative_cov;
}

TEST(Publish, StuffIsOfItsClassForSure) {
  MapNode road;
  road.id = 1, road.label = 40;
  road.stuff = true;
  road.belief = {Vec3(1, 2, 0), Mat3::Identity(), 400};
  const auto sent = completeGraph(mapperOf({road}), 0).objects.at(0);
  EXPECT_EQ(sent.classes, (ClassWeights{{40, 1.0F}}));
  EXPECT_EQ(sent.class_probability, 1);
}

TEST(Publish, StatusCountsKeyframesAndLoopsAndNoOtherConstraints) {
  KeyframeGraph keyframes = keyframesAtRest(4);
  for (const KeyframeId a : {0, 1, 2}) {
    keyframes.connect({a, a + 1, Pose::Identity(), 0.01, 0.01, false});
  }
  keyframes.connect({0, 3, Pose::Identity(), 0.01, 0.01, true});
  Status status;
  describeMap(mapperOf({}, keyframes).map(), status);
  EXPECT_EQ(status.keyframes, 4);
  EXPECT_EQ(status.loops, 1);
}

TEST(Publish, WhatOnlyMovedIsSentWithItsEdges) {
  const Drive drive(20);
  const Edge edge = drive.mapper.map().graph().edges().at(0);
  StepReport report;
  report.delta.moved = {edge.a, edge.b};
  const GraphUpdate moved = changedGraph(drive.mapper, report);
  ASSERT_EQ(moved.objects.size(), 2U);
  EXPECT_EQ(moved.objects[0].id, edge.a);
  EXPECT_EQ(moved.objects[0].belief.mean, drive.mapper.map().find(edge.a)->belief.mean);
  const auto sameEdge = [](const Edge& a, const Edge& b) { return a.a == b.a && a.b == b.b; };
  EXPECT_TRUE(std::ranges::equal(moved.edges, drive.mapper.map().graph().edgesOf({edge.a, edge.b}), sameEdge));
  EXPECT_FALSE(moved.edges.empty());
  report.delta = {};
  report.delta.changed = {edge.b};
  report.delta.moved = {edge.a};
  const GraphUpdate both = changedGraph(drive.mapper, report);
  ASSERT_EQ(both.objects.size(), 2U);
  EXPECT_EQ(both.objects[0].id, edge.a);
  EXPECT_EQ(both.objects[1].id, edge.b);
  ASSERT_FALSE(both.edges.empty());
  for (const Edge& e : both.edges) {
    EXPECT_TRUE(e.a == edge.a || e.b == edge.a || e.a == edge.b || e.b == edge.b);
  }
}

TEST(Publish, UpdatesAddUpToTheEdgesOfTheCompleteGraph) {
  const Drive drive(40);
  std::map<std::pair<NodeId, NodeId>, float> followed;
  for (const GraphUpdate& update : drive.updates) {
    const auto isAnew = [&](NodeId id) {
      return std::ranges::binary_search(update.objects, id, {}, &ObjectSummary::id) ||
             std::ranges::binary_search(update.removed, id);
    };
    std::erase_if(followed, [&](const auto& edge) { return isAnew(edge.first.first) || isAnew(edge.first.second); });
    for (const Edge& e : update.edges) {
      EXPECT_FALSE(followed.contains({e.a, e.b})) << "it has an end among what is new";
      followed[{e.a, e.b}] = e.weight;
    }
  }
  std::vector<std::pair<NodeId, NodeId>> ends, expected;
  for (const auto& [edge, weight] : followed) {
    ends.push_back(edge);
  }
  for (const Edge& e : completeGraph(drive.mapper, 5).edges) {
    expected.emplace_back(e.a, e.b);
  }
  ASSERT_GT(expected.size(), 10U);
  EXPECT_EQ(ends, expected);
}

TEST(Publish, RevisionsCountUpByOne) {
  const Drive drive(10);
  for (std::size_t i = 1; i < drive.updates.size(); ++i) {
    EXPECT_EQ(drive.updates[i].revision, drive.updates[i - 1].revision + 1);
  }
  EXPECT_EQ(completeGraph(drive.mapper, 0).revision, drive.updates.back().revision);
}

TEST(Publish, EdgesOfAnUpdateTouchItsObjects) {
  const Drive drive(10);
  for (const auto& update : drive.updates) {
    const auto has = [&](NodeId id) {
      return std::any_of(update.objects.begin(), update.objects.end(), [&](const auto& o) { return o.id == id; });
    };
    EXPECT_FALSE(update.edges.empty());
    for (const Edge& edge : update.edges) {
      EXPECT_TRUE(has(edge.a) || has(edge.b));
    }
  }
}

}  // namespace
}  // namespace hgg::graph_update_test
