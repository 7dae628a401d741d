#include "query/scene.h"

#include <algorithm>
#include <cmath>

#include "core/spd.h"

namespace hgg {
namespace {

/// Half an edge of a solid box in standard deviations; a leaf is taken to end where a sheet of its covariance would.
const double kEdgeInSigmas = std::sqrt(3.0);
constexpr double kLeastHalf = 0.005;  // m: nothing is thinner than a sheet of card

/// Of the leaves where there are some, else of the Gaussian as a solid box.
Eigen::AlignedBox3d boxOf(const MapNode& node) {
  Eigen::AlignedBox3d box;
  for (const Leaf& leaf : leavesOf(node)) {
    const Belief b = transform(node.T_map_object, unpackLeaf(leaf));
    const Vec3 half = kEdgeInSigmas * b.cov.diagonal().cwiseMax(0).cwiseSqrt();
    box.extend(b.mean - half);
    box.extend(b.mean + half);
  }
  if (box.isEmpty()) {
    const Vec3 half = kEdgeInSigmas * node.belief.cov.diagonal().cwiseMax(0).cwiseSqrt();
    box = Eigen::AlignedBox3d(node.belief.mean - half, node.belief.mean + half);
  }
  return box;
}

SceneThing thingOf(const Map& map, const MapNode& node) {
  SceneThing thing;
  const Eigen::AlignedBox3d box = boxOf(node);
  thing.id = node.id, thing.label = node.label, thing.stuff = node.stuff;
  thing.classes = node.stuff ? ClassWeights{{node.label, 1.0F}} : classProbabilities(node.classes);
  thing.centre = box.center();
  thing.half = (box.sizes() / 2).cwiseMax(kLeastHalf);
  thing.sigma = std::sqrt(positionCovariance(node).trace() / 3);
  thing.existence = existenceOf(node);
  if (node.looks.rgb) {
    thing.lab = labOf(*node.looks.rgb);
  }
  if (node.looks.front_object) {
    const Vec2 front = (node.T_map_object.linear() * *node.looks.front_object).head<2>();
    if (front.norm() > 0.1) {
      thing.front = front.normalized();
    }
  }
  if (node.anchor >= 0) {
    const Vec3& from = map.keyframes().poses()[static_cast<std::size_t>(node.anchor)].T_map_body.translation();
    if (const Vec2 towards = (from - thing.centre).head<2>(); towards.norm() > 0.1) {
      thing.seen_from = towards.normalized();
    }
  }
  return thing;
}

}  // namespace

QueryScene sceneOf(const Map& map) {
  QueryScene scene;
  scene.class_names = map.classNames();
  Eigen::AlignedBox3d all;
  Vec2 sum = Vec2::Zero();
  for (const auto& [id, node] : map.nodes()) {
    if (!isConfirmed(node)) {
      continue;
    }
    SceneThing thing = thingOf(map, node);
    all.extend(thing.centre - thing.half);
    all.extend(thing.centre + thing.half);
    sum += thing.centre.head<2>();
    for (const auto& [label, share] : thing.classes) {
      scene.of_class[label].push_back(static_cast<int>(scene.things.size()));
    }
    scene.things.push_back(std::move(thing));
  }
  if (!scene.things.empty()) {
    scene.low = all.min(), scene.high = all.max();
    scene.middle = sum / static_cast<double>(scene.things.size());
  }
  return scene;
}

void addEdges(const Map& map, QueryScene& scene) {
  constexpr EdgeModel kEdgeModel{0.01, 0.5};  // creation.sigma_floor and creation.edge_geometry_share as shipped
  std::map<NodeId, int> index;
  ObjectGraph graph;
  graph.setModel(kEdgeModel);
  for (std::size_t k = 0; k < scene.things.size(); ++k) {
    const MapNode* node = map.find(scene.things[k].id);
    if (node != nullptr && !node->stuff) {
      index[node->id] = static_cast<int>(k);
      graph.put(node->id, node->label, node->belief);
    }
  }
  graph.settle();
  for (const Edge& edge : graph.edges()) {
    const int a = index.at(edge.a), b = index.at(edge.b);
    scene.things[static_cast<std::size_t>(a)].edges[b] = edge.weight;
    scene.things[static_cast<std::size_t>(b)].edges[a] = edge.weight;
  }
}

double gapBetween(const SceneThing& a, const SceneThing& b) {
  return ((a.centre - b.centre).cwiseAbs() - a.half - b.half).cwiseMax(0).norm();
}

double groundGapBetween(const SceneThing& a, const SceneThing& b) {
  return ((a.centre - b.centre).cwiseAbs() - a.half - b.half).head<2>().cwiseMax(0).norm();
}

double footprintShare(const SceneThing& a, const SceneThing& b) {
  const Vec3 low = (a.centre - a.half).cwiseMax(b.centre - b.half),
             high = (a.centre + a.half).cwiseMin(b.centre + b.half);
  const Vec2 common = (high - low).head<2>().cwiseMax(0);
  return common.prod() / (4 * a.half.head<2>().prod());
}

Vec3 labOf(const std::array<std::uint8_t, 3>& rgb) {
  Vec3 linear;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double v = rgb[static_cast<std::size_t>(k)] / 255.0;
    linear[k] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  Mat3 to_xyz;  // sRGB to CIE XYZ, each divided by that of D65 white
  to_xyz << 0.4124 / 0.9505, 0.3576 / 0.9505, 0.1805 / 0.9505, 0.2126, 0.7152, 0.0722, 0.0193 / 1.089, 0.1192 / 1.089,
      0.9505 / 1.089;
  const Vec3 f = (to_xyz * linear).unaryExpr([](double t) {
    return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  });
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

}  // namespace hgg
