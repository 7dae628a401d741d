#include "map/object_graph.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "map/test_map.h"

namespace hgg::object_graph_test {
namespace {

constexpr ClassId kCar = 10, kPole = 80;
constexpr EdgeModel kModel{0.02, 0.3};

/// The graph by its definition: every pair against every third node, S1 and S2 of each edge, weights over all of them.
struct FromScratch {
  std::vector<Edge> edges;
  std::map<std::pair<NodeId, NodeId>, double> s1;

  explicit FromScratch(const Map& map, const EdgeModel& model = kModel) {
    std::vector<const MapNode*> nodes;
    for (const auto& [id, node] : map.nodes()) {
      if (isConfirmed(node)) {
        nodes.push_back(&node);
      }
    }
    double s1_max = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t j = i + 1; j < nodes.size(); ++j) {
        if (!isBlocked(nodes, *nodes[i], *nodes[j])) {
          const double distance = edgeDistance(nodes[i]->belief, nodes[j]->belief, model.sigma_floor);
          s1[{nodes[i]->id, nodes[j]->id}] = distance;
          s1_max = std::max(s1_max, distance);
        }
      }
    }
    for (const auto& [ends, distance] : s1) {
      const double s2 = map.find(ends.first)->label == map.find(ends.second)->label ? 0 : 1;
      const double geometry = s1_max > 0 ? model.geometry_share * distance / s1_max : 0;
      edges.push_back({ends.first, ends.second, static_cast<float>(geometry + (1 - model.geometry_share) * s2)});
    }
  }

  static bool isBlocked(const std::vector<const MapNode*>& nodes, const MapNode& a, const MapNode& b) {
    const auto square = [](const MapNode& x, const MapNode& y) {
      return (x.belief.mean - y.belief.mean).squaredNorm();
    };
    const double length = square(a, b);
    return std::ranges::any_of(
        nodes, [&](const MapNode* c) { return c != &a && c != &b && std::max(square(*c, a), square(*c, b)) < length; });
  }
};

void expectSameEdges(const std::vector<Edge>& actual, const std::vector<Edge>& expected, const std::string& when) {
  ASSERT_EQ(actual.size(), expected.size()) << when;
  for (std::size_t k = 0; k < actual.size(); ++k) {
    ASSERT_EQ(std::pair(actual[k].a, actual[k].b), std::pair(expected[k].a, expected[k].b)) << when;
    ASSERT_EQ(actual[k].weight, expected[k].weight) << when;  // to the last bit
  }
}

/// The map's graph is what it would be from scratch, asked for whole and node by node.
void expectExact(const Map& map, const std::string& when) {
  const FromScratch expected(map);
  ASSERT_TRUE(map.graph().isSettled()) << when;
  expectSameEdges(map.graph().edges(), expected.edges, when);
  std::size_t ends = 0;
  for (const auto& [id, node] : map.nodes()) {
    NodeId last = 0;
    for (const ObjectGraph::Neighbor& n : map.graph().neighborsOf(id)) {
      ASSERT_LT(last, n.id) << when;
      ASSERT_EQ(n.label, map.find(n.id)->label) << when;
      ASSERT_EQ(n.s1, expected.s1.at({std::min(id, n.id), std::max(id, n.id)})) << when;
      last = n.id;
      ++ends;
    }
  }
  ASSERT_EQ(ends, 2 * expected.edges.size()) << when;
}

/// Where nodes lie, in ways that are hard in their own way.
using Placement = Vec3 (*)(std::mt19937&);

Vec3 inSpace(std::mt19937& random) { return randomVector(random, 30); }
Vec3 onGround(std::mt19937& random) { return randomVector(random, 1).cwiseProduct(Vec3(60, 60, 1)); }
Vec3 onALattice(std::mt19937& random) { return Vec3(below(random, 5), below(random, 5), below(random, 2)) * 4; }
Vec3 onALine(std::mt19937& random) { return {uniform(random, -80, 80), 0, 0}; }
Vec3 inDistantClusters(std::mt19937& random) {
  const Vec3 centre(300.0 * below(random, 3), 150.0 * below(random, 2), 0);
  return centre + randomVector(random, 3);
}

MapNode someNode(std::mt19937& random, Placement place) {
  MapNode node = nodeAt(static_cast<ClassId>(kCar + below(random, 3)), place(random));
  node.belief.cov = randomSpd(random, 1e-3);
  if (below(random, 5) == 0) {
    node.classes = {};
    addViews(node.classes, {{static_cast<ClassId>(40), 1000.0F}});  // seen as something else: not confirmed
  }
  return node;
}

MapUpdate someUpdate(std::mt19937& random, const Map& map, Placement place, int step) {
  MapUpdate update;
  update.keyframe = NewKeyframe{};
  update.keyframe->pose.T_map_body.translation().x() = 2 * step;
  for (std::uint32_t n = below(random, 6); n > 0; --n) {
    update.created.push_back(someNode(random, place));
  }
  for (const auto& [id, node] : map.nodes()) {
    const std::uint32_t fate = below(random, 24);
    if (fate == 0) {
      update.removed.push_back(id);  // as when it fades, or is merged into another
    } else if (fate == 1) {
      update.changed.push_back(someNode(random, place));  // far away, perhaps not confirmed any more
      update.changed.back().anchor = node.anchor;
    } else if (fate <= 4) {
      update.changed.push_back(node);  // as most of them change: a little
      update.changed.back().belief.mean += randomVector(random, 0.05);
    } else if (fate == 5) {
      update.changed.push_back(node);  // in its extent and class only
      update.changed.back().belief.cov = randomSpd(random, 1e-3);
      update.changed.back().label = static_cast<ClassId>(kCar + below(random, 3));
    } else if (fate == 6) {
      update.evidence.push_back({id, PlaceView{.labels = {{node.label, 3000.0F}}}});  // confirmed from now on
      continue;
    } else {
      continue;
    }
    if (fate > 0) {
      update.changed.back().id = id;
    }
  }
  return update;
}

/// Moves this share of the keyframes, each in its own way, and what hangs on them.
MapCorrection someCorrection(std::mt19937& random, const Map& map, double share) {
  constexpr double extent = 2;  // m
  MapCorrection correction;
  for (KeyframeId k = 0; k <= map.keyframes().last(); ++k) {
    if (uniform(random, 0, 1) < share) {
      Pose move = Pose::Identity();
      move.linear() = Eigen::AngleAxisd(uniform(random, -0.05, 0.05), Vec3::UnitZ()).toRotationMatrix();
      move.translation() = randomVector(random, extent);
      correction.moved.emplace_back(k, move * map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body);
    }
  }
  return correction;
}

TEST(ObjectGraph, IsTheRelativeNeighborhoodAfterEveryRevision) {
  int case_number = 0;
  for (Placement place : {inSpace, onGround, onALattice, onALine, inDistantClusters}) {
    for (unsigned seed = 1; seed <= 3; ++seed, ++case_number) {
      std::mt19937 random(seed);
      Map map;
      map.setEdgeModel(kModel);
      for (int step = 0; step < 60; ++step) {
        const std::string when = "case " + std::to_string(case_number) + ", step " + std::to_string(step);
        map.apply(someUpdate(random, map, place, step));
        ASSERT_NO_FATAL_FAILURE(expectExact(map, when));
        if (step % 7 == 6) {
          map.apply(someCorrection(random, map, 0.5));
          ASSERT_NO_FATAL_FAILURE(expectExact(map, when + " after a loop"));
        }
      }
      EXPECT_GT(map.graph().size(), 20U);
      EXPECT_LT(map.graph().size(), map.nodes().size()) << "some are not confirmed";
    }
  }
}

/// A map so large that what a loop moves is not taken in at once.
Map largeMap(std::mt19937& random, Placement place, int nodes) {
  Map map;
  map.setEdgeModel(kModel);
  for (int step = 0; static_cast<int>(map.nodes().size()) < nodes; ++step) {
    MapUpdate update;
    update.keyframe = NewKeyframe{};
    update.keyframe->pose.T_map_body.translation().x() = 2 * step;
    for (int n = 0; n < 40; ++n) {
      update.created.push_back(someNode(random, place));
    }
    map.apply(std::move(update));
  }
  return map;
}

TEST(ObjectGraph, IsExactAgainAfterFramesAndLoopsThatCameBeforeALoopWasTakenIn) {
  for (Placement place : {onGround, inDistantClusters}) {
    std::mt19937 random(7);
    Map map = largeMap(random, place, 1200);
    map.apply(someCorrection(random, map, 0.9));
    EXPECT_FALSE(map.graph().isSettled());
    map.apply(someUpdate(random, map, place, 100));
    EXPECT_FALSE(map.graph().isSettled());
    map.apply(someCorrection(random, map, 0.9));
    for (int step = 101; !map.graph().isSettled(); ++step) {
      ASSERT_LT(step, 130);
      map.apply(someUpdate(random, map, place, step));
    }
    expectExact(map, "settled by the frames after it");
    map.apply(someCorrection(random, map, 0.9));
    map.apply(someUpdate(random, map, place, 131));
    map.settleGraph();
    expectExact(map, "settled at once");
  }
}

TEST(ObjectGraph, ALoopIsTakenInAroundTheRobotFirst) {
  std::mt19937 random(8);
  Map map = largeMap(
      random, [](std::mt19937& r) { return Vec3(uniform(r, -600, 600), uniform(r, -5, 5), 0); }, 900);
  const Vec3 robot = map.keyframes().poses().back().T_map_body.translation();
  MapCorrection correction;
  for (KeyframeId k = 0; k < map.keyframes().last(); ++k) {
    Pose T = map.keyframes().poses()[static_cast<std::size_t>(k)].T_map_body;
    T.translation() += randomVector(random, 4);
    correction.moved.emplace_back(k, T);
  }
  map.apply(correction);
  map.apply(MapUpdate{});
  ASSERT_FALSE(map.graph().isSettled());
  const FromScratch expected(map);
  std::size_t near = 0, far_wrong = 0;
  std::set<std::pair<NodeId, NodeId>> actual;
  for (const Edge& e : map.graph().edges()) {
    actual.emplace(e.a, e.b);
  }
  for (const auto& [ends, s1] : expected.s1) {
    const double distance = (map.find(ends.first)->belief.mean - robot).norm();
    if (distance < 30) {
      EXPECT_TRUE(actual.contains(ends)) << distance;
      ++near;
    } else {
      far_wrong += actual.contains(ends) ? 0 : 1;
    }
  }
  EXPECT_GT(near, 20U);
  EXPECT_GT(far_wrong, 20U);
}

TEST(ObjectGraph, NamesTheNodesWhoseEdgesAChangeOfOthersChanged) {
  std::mt19937 random(9);
  Map map;
  map.setEdgeModel(kModel);
  std::size_t rewired = 0;
  std::map<std::pair<NodeId, NodeId>, double> before;
  for (int step = 0; step < 60; ++step) {
    const MapDelta delta = map.apply(someUpdate(random, map, onGround, step));
    EXPECT_TRUE(std::ranges::is_sorted(delta.rewired));
    const std::map<std::pair<NodeId, NodeId>, double> after = FromScratch(map).s1;
    std::set<NodeId> expected;
    const auto note = [&](const auto& some, const auto& others) {
      for (const auto& [ends, s1] : some) {
        for (const NodeId id : {ends.first, ends.second}) {
          const bool is_as_it_was = map.find(id) != nullptr && !std::ranges::binary_search(delta.changed, id);
          const auto other = others.find(ends);
          if (is_as_it_was && (other == others.end() || std::abs(other->second - s1) > 1e-6 * s1)) {
            expected.insert(id);
          }
        }
      }
    };
    note(before, after), note(after, before);
    EXPECT_EQ(delta.rewired, std::vector<NodeId>(expected.begin(), expected.end())) << step;
    rewired += delta.rewired.size();
    before = after;
  }
  EXPECT_GT(rewired, 100U);
}

TEST(ObjectGraph, EdgesOfSomeNodesAreThoseOfTheWholeWithAnEndAmongThem) {
  std::mt19937 random(10);
  const Map map = largeMap(random, inDistantClusters, 200);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<NodeId> ids;
    for (NodeId id = 0; id < 230; ++id) {  // some are not there
      if (below(random, 1 + static_cast<std::uint32_t>(trial)) == 0) {
        ids.push_back(id);
      }
    }
    std::vector<Edge> expected = map.graph().edges();
    std::erase_if(expected, [&](const Edge& e) {
      return !std::ranges::binary_search(ids, e.a) && !std::ranges::binary_search(ids, e.b);
    });
    expectSameEdges(map.graph().edgesOf(ids), expected, std::to_string(trial));
  }
  double longest = 0;
  for (const Edge& e : map.graph().edges()) {
    longest = std::max(longest, (map.find(e.a)->belief.mean - map.find(e.b)->belief.mean).norm());
  }
  EXPECT_GT(longest, 100);
}

TEST(ObjectGraph, NeighborsAtAPlaceAreThoseANodeWouldHaveThere) {
  std::mt19937 random(11);
  const Map map = largeMap(random, onGround, 120);
  for (int trial = 0; trial < 50; ++trial) {
    const MapNode node = nodeAt(kPole, onGround(random));
    Map with = map;
    MapUpdate update;
    update.created = {node};
    const MapDelta delta = with.apply(std::move(update));
    std::vector<NodeId> expected, actual;
    for (const ObjectGraph::Neighbor& n : with.graph().neighborsOf(delta.changed.at(0))) {
      expected.push_back(n.id);
    }
    for (const ObjectGraph::Neighbor& n : map.graph().neighborsAt(node.belief.mean)) {
      actual.push_back(n.id);
      EXPECT_EQ(n.label, map.find(n.id)->label);
    }
    EXPECT_EQ(actual, expected);
  }
}

TEST(ObjectGraph, AFrameCostsTheSameWhateverElseTheMapHolds) {
  const auto computationsOfFrames = [](int elsewhere) {
    std::mt19937 random(12);
    std::vector<MapNode> nodes;
    for (int k = 0; k < 150 + elsewhere; ++k) {
      nodes.push_back(nodeAt(kCar, onGround(random)));
      nodes.back().id = k + 1;
      nodes.back().belief.mean.x() += k < 150 ? 0 : 1000 + 150.0 * (k / 150);
    }
    Map map = Map::restore(std::move(nodes), {}, {}, 1);
    map.setEdgeModel(kModel);
    const std::int64_t before = map.graph().computations();
    for (int frame = 0; frame < 5; ++frame) {
      MapUpdate update;
      for (NodeId id = 1; id <= 60; ++id) {
        update.changed.push_back(*map.find(id));
        update.changed.back().belief.mean += randomVector(random, 0.02);
      }
      map.apply(std::move(update));
    }
    return map.graph().computations() - before;
  };
  const std::int64_t alone = computationsOfFrames(0);
  EXPECT_LE(computationsOfFrames(15000), alone + 5 * 15);  // the rim of the map is not what it was
}

TEST(ObjectGraph, OfAMapWithoutAnEdgeModelIsEmpty) {
  std::mt19937 random(13);
  Map map = mapOf({nodeAt(kCar, Vec3(0, 0, 0)), nodeAt(kPole, Vec3(4, 0, 0))});
  EXPECT_TRUE(map.graph().edges().empty());
  EXPECT_TRUE(map.graph().isSettled());
  map.setEdgeModel(kModel);
  expectExact(map, "from then on");
  EXPECT_EQ(map.graph().edges().size(), 1U);
  map.setEdgeModel({kModel.sigma_floor, 0});
  EXPECT_EQ(map.graph().edges().at(0).weight, 1);
  MapUpdate update;
  update.removed = {1, 2};
  map.apply(std::move(update));
  EXPECT_TRUE(map.graph().edges().empty());
}

TEST(ObjectGraph, SharesOneWeightWhereAllNodesAreInOnePlace) {
  Map map;
  map.setEdgeModel(kModel);
  MapUpdate update;
  for (int k = 0; k < 40; ++k) {
    update.created.push_back(nodeAt(kCar, Vec3(1, 2, 3)));
  }
  map.apply(std::move(update));
  expectExact(map, "copies are all neighbours");
  EXPECT_EQ(map.graph().edges().size(), 40U * 39 / 2);
}

/// What only changed its shape is not computed anew when it is taken in, so nothing may be left to that.
TEST(ObjectGraph, ANodeThatOnlyChangedItsShapeBeforeALoopStillGainsTheEdgesThatOpenUpMeanwhile) {
  std::mt19937 random(9);
  ObjectGraph graph;
  graph.setModel(kModel);
  const Belief a{Vec3(0, 0, 0), Mat3::Identity(), 10}, c{Vec3(10, 0, 0), Mat3::Identity(), 10};
  graph.put(1, kCar, a);
  graph.put(2, kCar, c);
  graph.put(3, kCar, {Vec3(5, 0.5, 0), Mat3::Identity(), 10});  // between the two
  std::vector<Belief> others;
  for (NodeId id = 10; id < 510; ++id) {
    others.push_back({Vec3(1000, 0, 0) + randomVector(random, 100), Mat3::Identity(), 10});
    graph.put(id, kCar, others.back());
  }
  graph.refresh(ObjectGraph::Postponed::kLeave);
  ASSERT_EQ(graph.neighborsOf(1).size(), 1U);
  for (std::size_t k = 0; k < others.size(); ++k) {
    others[k].mean += randomVector(random, 1);
    graph.move(static_cast<NodeId>(10 + k), others[k]);
  }
  graph.put(1, kCar, {a.mean, 2 * a.cov, 10});
  graph.postpone(Vec3(1000, 0, 0));
  graph.remove(3);
  while (!graph.isSettled()) {
    graph.refresh(ObjectGraph::Postponed::kTakeSome);
  }
  ASSERT_EQ(graph.neighborsOf(1).size(), 1U);
  EXPECT_EQ(graph.neighborsOf(1).front().id, 2);
  EXPECT_DOUBLE_EQ(graph.neighborsOf(1).front().s1, edgeDistance({a.mean, 2 * a.cov, 10}, c, kModel.sigma_floor));
}

}  // namespace
}  // namespace hgg::object_graph_test
