#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/units.h"
#include "map/test_map.h"

namespace hgg {

constexpr ClassId kChair = 10, kTable = 11, kLamp = 12, kWall = 1, kFloor = 2;
inline const std::map<ClassId, std::string> kNames{
    {kChair, "chair"}, {kTable, "table"}, {kLamp, "lamp"}, {kWall, "wall"}, {kFloor, "floor"}};

/// What there is: things and pieces of flat surfaces.
struct Patch {
  ClassId label;
  Vec3 mean;
  Mat3 cov;
  int views = 10;
  float taken_for_wall = 0;  // views
};
struct World {
  std::vector<Patch> things, stuff;
};

inline Mat3 plate(const Vec3& normal, double half) {
  const Vec3 n = normal.normalized();
  return 0.33 * half * half * (Mat3::Identity() - n * n.transpose()) + 1e-4 * n * n.transpose();
}

inline void addWall(World& world, const Vec3& from, const Vec3& along) {
  const Vec3 normal = along.cross(Vec3::UnitZ());
  for (double s = 0.5; s < along.norm(); ++s) {
    for (const double z : {0.5, 1.5}) {
      world.stuff.push_back({kWall, from + s * along.normalized() + z * Vec3::UnitZ(), plate(normal, 0.5)});
    }
  }
}

inline void addFloor(World& world, double extent) {
  for (double x = -extent + 0.5; x < extent; ++x) {
    for (double y = -extent + 0.5; y < extent; ++y) {
      world.stuff.push_back({kFloor, Vec3(x, y, 0), plate(Vec3::UnitZ(), 0.5)});
    }
  }
}

inline World randomWorld(unsigned seed, int things = 30, double extent = 15) {
  std::mt19937 random(seed);
  World world;
  for (int k = 0; k < things; ++k) {
    const Vec3 p = randomVector(random, extent);
    const double size = 0.1 * (1 + k % 3);
    world.things.push_back(
        {static_cast<ClassId>(kChair + k % 3), Vec3(p.x(), p.y(), 0.4 + size), size * size * Mat3::Identity()});
  }
  for (int k = 0; k < 8; ++k) {
    const Vec3 p = randomVector(random, 0.7 * extent), way = randomVector(random, 1);
    addWall(world, Vec3(p.x(), p.y(), 0), 6 * Vec3(way.x(), way.y(), 0).normalized());
  }
  addFloor(world, extent);
  return world;
}

/// The nodes of a world in a map whose frame has the pose T_world_map, of what `sees` admits; things jitter by 2 cm.
inline std::vector<MapNode> nodesOfWorld(const World& world, const Pose& T_world_map, unsigned noise_seed,
                                         const std::function<bool(const Vec3&)>& sees = {}) {
  std::mt19937 random(noise_seed);
  std::vector<MapNode> nodes;
  std::map<std::tuple<ClassId, int, int>, std::size_t> tiles;  // of this map's own frame
  for (const std::vector<Patch>* patches : {&world.things, &world.stuff}) {
    for (const Patch& patch : *patches) {
      if (sees && !sees(patch.mean)) {
        continue;
      }
      const Belief belief = transform(T_world_map.inverse(), {patch.mean + randomVector(random, 0.02), patch.cov, 50});
      const bool stuff = patches == &world.stuff;
      const std::tuple tile(patch.label, static_cast<int>(std::floor(belief.mean.x() / 3)),
                            static_cast<int>(std::floor(belief.mean.y() / 3)));
      if (!stuff || !tiles.contains(tile)) {
        tiles[tile] = nodes.size();
        MapNode node;
        node.label = patch.label;
        node.stuff = stuff;
        node.tile = {std::get<1>(tile), std::get<2>(tile), 0};
        node.views = patch.views;
        if (!stuff) {
          addViews(node.classes, {{kWall, patch.taken_for_wall}});
          addViews(node.classes, {{patch.label, static_cast<float>(patch.views)}});
        }
        node.belief = belief;
        nodes.push_back(node);
      }
      addLeaf(nodes[stuff ? tiles[tile] : nodes.size() - 1], packLeaf(belief));  // T_map_object is identity
    }
  }
  return nodes;
}

/// A map of its own of them.
inline Map mapOfWorld(const World& world, const Pose& T_world_map, unsigned noise_seed,
                      const std::function<bool(const Vec3&)>& sees = {},
                      std::map<ClassId, std::string> names = kNames) {
  Map map = mapOf(nodesOfWorld(world, T_world_map, noise_seed, sees));
  map.setClassNames(std::move(names));
  return map;
}

inline Pose frame(double yaw_deg, const Vec3& t, double tilt_deg = 0) {
  Pose T = Pose::Identity();
  T.linear() = (Eigen::AngleAxisd(yaw_deg * kDegree, Vec3::UnitZ()) *
                Eigen::AngleAxisd(tilt_deg * kDegree, Vec3(1, 2, 0).normalized()))
                   .toRotationMatrix();
  T.translation() = t;
  return T;
}

}  // namespace hgg
