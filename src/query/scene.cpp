#include "query/scene.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <span>

#include "core/spd.h"

namespace hgg {
namespace {

/// Half an edge of a solid box in standard deviations; a leaf is taken to end where a sheet of its covariance would.
const double kEdgeInSigmas = std::sqrt(3.0);
/// Below this a class is what a segmenter that mistakes one object in ten sees now and then, and nobody means by it.
constexpr double kLeastBelief = 0.15;
constexpr double kLeastHalf = 0.005;  // m: nothing is thinner than a sheet of card

/// The direction, up to quarter turns, of most upright surfaces seen from above; 0 where there is none. Each adds a
/// vector of four times its angle, as long as the surface.
double yawOfWalls(const MapLeaves& map) {
  constexpr double kUpright = 0.5;     // of its length, that a surface at least is high
  constexpr double kLeastAlike = 0.2;  // of all lengths, that the vectors together are long: else there is no direction
  std::complex<double> sum = 0;
  double lengths = 0;  // m
  for (const auto& [id, node] : map.nodes) {
    for (const Leaf& leaf : isConfirmed(node) ? leavesOf(node) : std::span<const Leaf>{}) {
      const Mat3 cov = transform(node.T_map_object, unpackLeaf(leaf)).cov;
      const std::complex<double> twice(cov(0, 0) - cov(1, 1), 2 * cov(0, 1));  // its angle twice; its length squared
      const double length = std::sqrt(std::abs(twice));
      if (length > 0 && std::sqrt(cov(2, 2)) > kUpright * length) {
        sum += length * std::pow(twice / std::abs(twice), 2);
        lengths += length;
      }
    }
  }
  return std::abs(sum) > kLeastAlike * lengths ? std::arg(sum) / 4 : 0;
}

/// Of the leaves where there are some, else of the Gaussian as a solid box.
Eigen::AlignedBox3d boxOf(const MapNode& node, const Pose& T_scene_map) {
  Eigen::AlignedBox3d box;
  const Pose T_scene_object = T_scene_map * node.T_map_object;
  for (const Leaf& leaf : leavesOf(node)) {
    const Belief b = transform(T_scene_object, unpackLeaf(leaf));
    const Vec3 half = kEdgeInSigmas * b.cov.diagonal().cwiseMax(0).cwiseSqrt();
    box.extend(b.mean - half);
    box.extend(b.mean + half);
  }
  if (box.isEmpty()) {
    const Belief b = transform(T_scene_map, node.belief);
    const Vec3 half = kEdgeInSigmas * b.cov.diagonal().cwiseMax(0).cwiseSqrt();
    box = Eigen::AlignedBox3d(b.mean - half, b.mean + half);
  }
  return box;
}

SceneThing thingOf(const MapLeaves& map, const MapNode& node, const Pose& T_scene_map) {
  SceneThing thing;
  const Eigen::AlignedBox3d box = boxOf(node, T_scene_map);
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
    const Vec2 front = (T_scene_map.linear() * node.T_map_object.linear() * *node.looks.front_object).head<2>();
    if (front.norm() > 0.1) {
      thing.front = front.normalized();
    }
  }
  if (node.anchor >= 0) {
    const Vec3 from = T_scene_map * map.keyframes[static_cast<std::size_t>(node.anchor)].T_map_body.translation();
    if (const Vec2 towards = (from - thing.centre).head<2>(); towards.norm() > 0.1) {
      thing.seen_from = towards.normalized();
    }
  }
  return thing;
}

}  // namespace

QueryScene sceneOf(const Map& map) { return sceneOf(map, map.classNames()); }

QueryScene sceneOf(const MapLeaves& map, const std::map<ClassId, std::string>& class_names) {
  QueryScene scene;
  scene.class_names = class_names;
  scene.yaw = yawOfWalls(map);
  const Pose T_scene_map(Eigen::AngleAxisd(-scene.yaw, Vec3::UnitZ()));
  Eigen::AlignedBox3d all;
  Vec2 sum = Vec2::Zero();
  for (const auto& [id, node] : map.nodes) {
    if (!isConfirmed(node)) {
      continue;
    }
    SceneThing thing = thingOf(map, node, T_scene_map);
    all.extend(thing.centre - thing.half);
    all.extend(thing.centre + thing.half);
    sum += thing.centre.head<2>();
    for (const auto& [label, share] : thing.classes) {
      if (share >= kLeastBelief) {
        scene.of_class[label].push_back(static_cast<int>(scene.things.size()));
      }
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
