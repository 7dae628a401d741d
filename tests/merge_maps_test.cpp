#include "merge_maps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "random_world.h"

namespace hgg::merge_maps_test {
namespace {

constexpr double kTile = 3;

ClassTable classes() {
  const auto table = ClassTable::parse(R"(
[[class]]
id = 10
name = "chair"
kind = "thing"
radius = 0.3
min_points = 5
[[class]]
id = 11
name = "table"
kind = "thing"
radius = 0.3
min_points = 5
[[class]]
id = 12
name = "lamp"
kind = "thing"
radius = 0.3
min_points = 5
[[class]]
id = 1
name = "wall"
kind = "stuff"
min_points = 5
[[class]]
id = 2
name = "floor"
kind = "stuff"
min_points = 5
)",
                                       "test classes");
  EXPECT_TRUE(table) << table.error;
  return *table;
}

Config config() {
  Config config;
  config.creation.tile_size = kTile;
  config.map.leaf_size = 0.4;
  return config;
}

Map mapFrom(const World& world, const Pose& T_world_map, unsigned seed,
            const std::function<bool(const Vec3&)>& sees = {}) {
  Map map = mapOfWorld(world, T_world_map, seed, sees);
  map.setTileSize(kTile);
  return map;
}

/// How often the world's things are in a map whose frame is the world's: times to number of things.
std::map<int, int> countThings(const World& world, const Map& map) {
  std::map<int, int> counts;
  for (const Patch& thing : world.things) {
    int found = 0;
    for (const NodeId id : map.nearAnywhere(thing.mean, 0.15)) {
      found += map.find(id)->label == thing.label ? 1 : 0;
    }
    ++counts[found];
  }
  return counts;
}

TEST(MergeMaps, TwoMapsOfOnePlaceBecomeOneWithTheEvidenceOfBoth) {
  const World world = randomWorld(3, 60);
  const Map a = mapFrom(world, Pose::Identity(), 1), b = mapFrom(world, frame(130, Vec3(40, -7, 1)), 2);
  const MergedMaps merged = mergeMaps({a, b}, classes(), config());
  ASSERT_TRUE(merged.accepted) << merged.reason;
  std::map<int, int> counts = countThings(world, merged.map);
  EXPECT_GE(counts[1], 57) << "but for things that lie in each other";
  EXPECT_EQ(counts[0] + counts[1], 60) << "no thing is there twice";
  double kappa = 0, kappa_of_both = 0;
  for (const auto& [id, node] : merged.map.nodes()) {
    kappa += node.belief.kappa;
  }
  for (const Map* map : {&a, &b}) {
    for (const auto& [id, node] : map->nodes()) {
      kappa_of_both += node.belief.kappa;
    }
  }
  EXPECT_NEAR(kappa, kappa_of_both, 1e-6);
  EXPECT_GT(merged.joined, world.things.size() * 9 / 10);
}

TEST(MergeMaps, AMapOfAnotherPlaceIsRefusedWhateverTheOrder) {
  const World world = randomWorld(3, 60), elsewhere = randomWorld(77, 60);
  const Map a = mapFrom(world, Pose::Identity(), 1), b = mapFrom(world, frame(40, Vec3(9, 0, 0)), 2),
            foreign = mapFrom(elsewhere, Pose::Identity(), 3);
  for (const auto& maps : {std::vector{a, b, foreign}, std::vector{foreign, a, b}, std::vector{a, foreign}}) {
    const MergedMaps merged = mergeMaps(maps, classes(), config());
    EXPECT_FALSE(merged.accepted);
    EXPECT_NE(merged.reason, "");
  }
}

TEST(MergeMaps, MapsThatOverlapInAChainAreJoinedInAnyOrder) {
  const World world = randomWorld(5, 90);
  std::vector<Map> maps;
  const double starts[] = {-15, -8, -1};
  for (unsigned k = 0; k < 3; ++k) {
    maps.push_back(mapFrom(world, frame(70.0 * k, Vec3(10.0 * k, 3, 0)), 10 + k,
                           [&](const Vec3& p) { return p.x() >= starts[k] && p.x() < starts[k] + 16; }));
  }
  std::vector<std::size_t> order{0, 1, 2};
  std::vector<std::size_t> nodes;
  do {
    const MergedMaps merged = mergeMaps({maps[order[0]], maps[order[1]], maps[order[2]]}, classes(), config());
    ASSERT_TRUE(merged.accepted) << merged.reason;
    nodes.push_back(static_cast<std::size_t>(
        std::ranges::count_if(merged.map.nodes(), [](const auto& entry) { return !entry.second.stuff; })));
  } while (std::ranges::next_permutation(order).found);
  const auto [least, most] = std::ranges::minmax(nodes);
  EXPECT_LE(most - least, 2U);
}

TEST(MergeMaps, ClassesAreMatchedByName) {
  const World world = randomWorld(3, 60);
  const Map a = mapFrom(world, Pose::Identity(), 1);
  std::vector<MapNode> nodes;
  const Map b = mapFrom(world, frame(130, Vec3(40, -7, 1)), 2);
  for (const auto& [id, node] : b.nodes()) {
    nodes.push_back(node);
    nodes.back().anchor = -1;
    nodes.back().label = static_cast<ClassId>(node.label + 100);
    for (auto& [label, views] : nodes.back().classes.views) {
      label = static_cast<ClassId>(label + 100);
    }
  }
  Map renamed = Map::restore(std::move(nodes), {}, {}, 1);
  renamed.setClassNames({{110, "chair"}, {111, "table"}, {112, "lamp"}, {101, "wall"}, {102, "floor"}});
  renamed.setTileSize(kTile);
  const MergedMaps merged = mergeMaps({a, renamed}, classes(), config());
  ASSERT_TRUE(merged.accepted) << merged.reason;
  EXPECT_EQ(merged.map.classNames(), kNames);
  EXPECT_GE(countThings(world, merged.map)[1], 57);
}

}  // namespace
}  // namespace hgg::merge_maps_test
