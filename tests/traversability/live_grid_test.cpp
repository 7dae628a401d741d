#include "traversability/live_grid.h"

#include <gtest/gtest.h>

#include <random>

#include "surfaces_world.h"
#include "traversability/leaf_copy.h"

namespace hgg::live_grid_test {
namespace {

::testing::AssertionResult areEqual(const CostGrid& a, const CostGrid& b) {
  if (a.first != b.first) {
    return ::testing::AssertionFailure() << "other columns have surfaces";
  }
  for (std::size_t k = 0; k < a.supports.size(); ++k) {
    if (a.supports[k] != b.supports[k]) {
      const auto cell = std::upper_bound(a.first.begin(), a.first.end(), k) - a.first.begin() - 1;
      return ::testing::AssertionFailure()
             << "surface " << k << " at " << cell % a.shape.width << ", " << cell / a.shape.width << ": height "
             << a.supports[k].height << " and " << b.supports[k].height << ", cost " << int{a.supports[k].cost}
             << " and " << int{b.supports[k].cost};
    }
  }
  return ::testing::AssertionSuccess();
}

/// A street of sorts with what makes a grid look far: a kerb, a table, a hole, a car of which only the outside was
/// seen, and ground with gaps.
Map someStreet() {
  SurfacesWorld world;
  world.setEye({0, 0, 1.5});
  world.addFloor(-8, -4, 8, 0, 0, 30, 0.4);
  world.add({-8, 0, 0}, {16, 0, 0}, {0, 0, 0.14});
  world.addFloor(-8, 0, 2, 4, 0.14, 20, 0.5);
  world.addFloor(3, 0.5, 8, 4, 0.14, 5, 0.7);
  world.addFloor(-3, -3, -2, -2, 0.6, 30, 0.25);
  world.addSides(3, -3, 5, -1.2, 0.2, 1.2, 60);
  world.addFloor(-8, 4, 8, 6, -1.5, 10, 0.8);
  world.addFloor(-6, -4, 6, 4, 0.02, 1, 2.5);  // a first, distant look
  return world.map();
}

/// Changes to a map as mapping makes them, at random.
class Changer {
 public:
  explicit Changer(unsigned seed) : random_(seed) {}

  MapDelta change(Map& map) {
    if (below(10) == 0) {
      return turnKeyframe(map);
    }
    MapUpdate update;
    for (std::uint32_t k = 1 + below(3); k > 0; --k) {
      auto node = map.nodes().begin();
      std::advance(node, below(static_cast<std::uint32_t>(map.nodes().size())));
      if (std::ranges::any_of(update.changed, [&](const MapNode& n) { return n.id == node->first; })) {
        continue;
      }
      update.changed.push_back(changed(node->second));
    }
    if (below(4) == 0) {
      update.created.push_back(somethingNew());
    }
    if (below(6) == 0 && map.nodes().size() > 8) {
      const NodeId last = map.nodes().rbegin()->first;
      std::erase_if(update.changed, [&](const MapNode& n) { return n.id == last; });
      update.removed.push_back(last);
    }
    return map.apply(std::move(update));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }

 private:
  MapNode changed(MapNode node) {
    Leaves leaves = leavesOf(node);
    for (std::uint32_t k = below(6); k > 0 && !leaves.empty(); --k) {
      const std::size_t i = below(static_cast<std::uint32_t>(leaves.size()));
      switch (below(4)) {
        case 0:
          leaves.erase(leaves.begin() + static_cast<std::ptrdiff_t>(i));
          break;
        case 1:
          leaves.insert(leaves.begin() + static_cast<std::ptrdiff_t>(below(static_cast<std::uint32_t>(leaves.size()))),
                        leaves[i]);
          leaves[i].mean[0] += static_cast<float>(uniform(-1, 1));
          break;
        case 2:
          leaves[i].mean[2] += static_cast<float>(uniform(-0.3, 0.3));
          break;
        default:
          leaves[i].kappa *= static_cast<float>(std::exp(uniform(-4, 4)));
      }
    }
    node.views = std::max(1, node.views + static_cast<int>(below(5)) - 1);
    node.classes = {};
    if (below(8) > 0) {  // else a thing that nobody believes in, for now
      addViews(node.classes, {{node.label, 1000.0F}});
    }
    node.geometry = shareLeaves(std::move(leaves));
    return node;
  }

  MapNode somethingNew() {
    MapNode node = nodeAt(1, {uniform(-6, 6), uniform(-4, 4), uniform(0, 1)});
    node.anchor = 0;
    for (int k = 0; k < 20; ++k) {
      Belief leaf;
      leaf.mean = {uniform(-1, 1), uniform(-1, 1), uniform(-0.2, 0.2)};
      leaf.cov = Vec3(uniform(0.001, 0.05), uniform(0.001, 0.05), 1e-4).asDiagonal();
      leaf.kappa = uniform(1, 200);
      addLeaf(node, packLeaf(leaf));
    }
    return node;
  }

  MapDelta turnKeyframe(Map& map) {
    Pose pose = map.keyframes().poses()[0].T_map_body;
    pose.translation() += Vec3(uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-0.02, 0.02));
    pose.rotate(Eigen::AngleAxisd(uniform(-0.02, 0.02), Vec3::UnitZ()));
    MapCorrection correction;
    correction.moved = {{0, pose}};
    return map.apply(correction);
  }

  std::mt19937 random_;
};

/// The grid after the map has rested.
const CostGrid& rested(LiveGrid& live, const MapLeaves& map, const GridShape& window) {
  for (int turn = 1; turn < live.restsAfter(); ++turn) {
    live.update(map, window);
  }
  return live.update(map, window);
}

TEST(LiveGrid, IsTheGridOfTheRestingMapAfterAnyChangesAndMoves) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Map map = someStreet();
    Changer changer(seed);
    TraversabilityConfig limits;
    LiveGrid live(limits), of_copy(limits), in_turns(limits, 8);
    LeafCopy copy;
    copy.apply(allOf(map));
    std::vector<NodeId> touched;
    Eigen::Vector2d robot(0, 0);
    for (int round = 0; round < 40; ++round) {
      for (std::uint32_t k = changer.below(3); k > 0; --k) {
        const MapDelta delta = changer.change(map);
        for (const auto* ids : {&delta.changed, &delta.moved, &delta.removed}) {
          touched.insert(touched.end(), ids->begin(), ids->end());
        }
      }
      if (changer.below(3) == 0) {
        robot += Eigen::Vector2d(changer.uniform(-1.5, 1.5), changer.uniform(-1.5, 1.5));
      }
      const double half = round % 13 == 12 ? 4 : 5;
      const GridShape window =
          *gridShape({robot.x() - half, robot.y() - half, robot.x() + half, robot.y() + half}, limits.resolution);
      const CostGrid expected = buildCostGrid(map, window, limits);
      ASSERT_GT(expected.supports.size(), 100U);
      live.update(map, window);
      in_turns.update(map, window, robot);
      const bool rests = changer.below(2) == 0;  // else the next change finds it as it is
      if (rests) {
        ASSERT_TRUE(areEqual(rested(live, map, window), expected)) << "seed " << seed << ", round " << round;
      }
      if (rests && seed == 1U) {
        ASSERT_TRUE(areEqual(rested(in_turns, map, window), expected)) << "in turns, seed " << seed << ", " << round;
      }
      copy.apply(changesOf(map, touched));
      touched.clear();
      of_copy.update(copy.leaves(), window);
      if (rests) {
        ASSERT_TRUE(areEqual(rested(of_copy, copy.leaves(), window), expected)) << "seed " << seed << ", " << round;
      }
    }
  }
}

TEST(LiveGrid, WorksOnNothingWhereNothingChangedAndNearAChangeOnly) {
  Map map = someStreet();
  const TraversabilityConfig limits;
  const GridShape window = *gridShape({-6, -6, 6, 6}, limits.resolution);
  LiveGrid live(limits);
  live.update(map, window);
  EXPECT_EQ(live.work().columns, static_cast<std::size_t>(window.cells()));
  live.update(map, window);
  EXPECT_EQ(live.work().columns, 0U);
  EXPECT_EQ(live.work().judged, 0U);
  MapNode floor = map.nodes().begin()->second;
  Leaves leaves = leavesOf(floor);
  leaves[leaves.size() / 2].mean[2] += 0.05F;
  floor.geometry = shareLeaves(std::move(leaves));
  MapUpdate update;
  update.changed = {floor};
  map.apply(std::move(update));
  const CostGrid expected = buildCostGrid(map, window, limits);
  live.update(map, window);
  EXPECT_GT(live.work().columns, 10U);
  EXPECT_LT(live.work().columns, 100U);
  EXPECT_GT(live.work().judged, 10U);
  EXPECT_LT(live.work().judged, static_cast<std::size_t>(window.cells()) / 4);
  EXPECT_LT(live.work().looked_at, static_cast<std::size_t>(window.cells()) / 4);
  EXPECT_TRUE(areEqual(rested(live, map, window), expected));
}

TEST(LiveGrid, InTurnsTakesUpWhatIsNearTheRobotSoonAndTheRestWhenItsTurnComes) {
  constexpr int kTurns = 32;
  SurfacesWorld before, after;
  before.addFloor(-19, -19, 19, 19, 0, 30, 0.5);
  after.addFloor(-19, -19, 19, 19, 0.03, 30, 0.5);
  const Map was = before.map(), is = after.map();
  const TraversabilityConfig limits;
  const GridShape window = *gridShape({-20, -20, 20, 20}, limits.resolution);
  LiveGrid live(limits, kTurns);
  live.update(was, window);
  const CostGrid expected = buildCostGrid(is, window, limits);
  const auto isThere = [&](const CostGrid& grid, double x, double y) {
    return std::abs(supportAt(grid, x, y)->height - supportAt(expected, x, y)->height) < 1e-6;
  };
  int farthest = 0;
  for (int turn = 1; turn <= kTurns; ++turn) {
    const CostGrid& grid = live.update(is, window);
    EXPECT_LT(live.work().columns, static_cast<std::size_t>(window.cells()) / 6) << turn;
    if (turn == Turn::kNearTurns) {
      for (const double x : {-3.05, 0.05, 3.05}) {
        EXPECT_TRUE(isThere(grid, x, 0.05)) << x;
      }
    }
    farthest = isThere(grid, 15.05, -15.05) && farthest == 0 ? turn : farthest;
  }
  EXPECT_GT(farthest, 0);
  EXPECT_TRUE(areEqual(rested(live, is, window), expected));
}

TEST(LiveGrid, AnotherResolutionBeginsAnew) {
  const Map map = someStreet();
  const TraversabilityConfig limits;
  LiveGrid live(limits);
  for (const double resolution : {0.1, 0.2, 0.1}) {
    const GridShape window = *gridShape({-3, -3, 3, 3}, resolution);
    EXPECT_TRUE(areEqual(live.update(map, window), buildCostGrid(map, window, limits))) << resolution;
  }
}

}  // namespace
}  // namespace hgg::live_grid_test
