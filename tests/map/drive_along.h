#pragma once

#include <random>
#include <utility>
#include <vector>

#include "map/test_map.h"

namespace hgg::paging_test {

constexpr ClassId kCar = 10, kRoad = 40;
constexpr double kTileSize = 10;  // m

inline Pose at(double x, double y = 0) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(x, y, 0);
  return T;
}

/// A drive along x, a keyframe every 5 m, a car of so many leaves and a road node beside each.
inline Map driveAlong(int keyframes, int leaves = 3) {
  std::mt19937 random(7);
  KeyframeGraph graph;
  std::vector<MapNode> nodes;
  for (int k = 0; k < keyframes; ++k) {
    graph.add({1000 * k, at(5 * k)});
    if (k > 0) {
      graph.connect({k - 1, k, at(5), 0.02, 1e-3, false});
    }
    nodes.push_back(nodeAt(kCar, Vec3(5 * k, 4, 0)));
    for (int n = 0; n < leaves; ++n) {
      addLeaf(nodes.back(), randomLeaf(random));
    }
    const Vec3 road(5 * k, -1, 0);
    nodes.push_back(tileNode(kRoad, tileOf(road, kTileSize), road));
  }
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    nodes[n].id = static_cast<NodeId>(n + 1);
    nodes[n].anchor = static_cast<KeyframeId>(n / 2);
  }
  Map map = Map::restore(std::move(nodes), std::move(graph), {{kCar, "car"}, {kRoad, "road"}}, 1);
  map.setTileSize(kTileSize);
  map.setEdgeModel({0.02, 0.3});
  return map;
}

}  // namespace hgg::paging_test
