#include "map/geometry.h"

#include <gtest/gtest.h>

#include "map/test_map.h"
#include "random_geometry.h"

namespace hgg::geometry_test {
namespace {

std::vector<Belief> randomLeaves(std::mt19937& random, int count) {
  std::vector<Belief> leaves;
  for (int k = 0; k < count; ++k) {
    leaves.push_back(randomBelief(random, 3));
  }
  return leaves;
}

TEST(Geometry, EdgesAreTheRelativeNeighborhoodOfTheLeaves) {
  std::mt19937 random(1);
  const std::vector<Belief> leaves = randomLeaves(random, 40);
  const auto distance = [&](int i, int j) {
    return (leaves[static_cast<std::size_t>(i)].mean - leaves[static_cast<std::size_t>(j)].mean).norm();
  };
  std::vector<std::pair<int, int>> expected;
  for (int i = 0; i < 40; ++i) {
    for (int j = i + 1; j < 40; ++j) {
      bool is_blocked = false;
      for (int k = 0; k < 40; ++k) {
        is_blocked |= k != i && k != j && std::max(distance(i, k), distance(j, k)) < distance(i, j);
      }
      if (!is_blocked) {
        expected.emplace_back(i, j);
      }
    }
  }
  EXPECT_EQ(geometryEdges(leaves), expected);
}

TEST(Geometry, BlockOfAMapOutlivesWhatTheMapDoesToItsNode) {
  std::mt19937 random(2);
  MapNode node = nodeAt(10, Vec3(1, 2, 3));
  node.geometry = shareLeaves({randomLeaf(random), randomLeaf(random)});
  Map map = mapOf({node});
  const GeometryBlock before = map.geometry(1);
  const Leaves content = *before;
  MapUpdate update;
  update.changed = {*map.find(1)};
  addLeaf(update.changed[0], randomLeaf(random));
  map.apply(std::move(update));
  EXPECT_EQ(map.geometry(1)->size(), 3U);
  ASSERT_EQ(before->size(), 2U);
  EXPECT_EQ((*before)[1].mean, content[1].mean);
}

TEST(Geometry, CopiesOfAMapShareTheirBlocks) {
  std::mt19937 random(3);
  const Map map = mapOf({randomNode(random, 10), randomNode(random, 10)});
  const Map snapshot = map;
  for (const auto& [id, node] : map.nodes()) {
    EXPECT_EQ(map.geometry(id), snapshot.geometry(id)) << id;  // the same block, not an equal one
  }
}

TEST(GeometryDeathTest, ReadingANodeThatIsNotThereOrNotInMemoryAborts) {
  const Map map = mapOf({nodeAt(10, Vec3::Zero())});
  EXPECT_DEATH(map.geometry(7), "");
  MapNode away = *map.find(1);
  away.geometry = nullptr;
  EXPECT_DEATH(leavesOf(away), "");
}

}  // namespace
}  // namespace hgg::geometry_test
