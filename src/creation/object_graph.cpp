#include "creation/object_graph.h"

#include <algorithm>

#include "core/neighborhood.h"
#include "creation/geometry_graph.h"
#include "creation/instances.h"

namespace hgg {
namespace {

Belief beliefOf(std::span<const PackedPoint> points) {
  Moments moments(points[0].head<3>().cast<double>());
  for (const PackedPoint& p : points) {
    moments.add(p[0], p[1], p[2]);
  }
  return moments.belief();
}

LocalObject createObject(const Instance& instance, std::span<PackedPoint> points, const CreationConfig& config) {
  LocalObject object;
  object.label = instance.label;
  object.instance = instance.instance;
  object.stuff = instance.stuff;
  object.tile = instance.tile;
  object.belief = beliefOf(points);
  object.T_body_object = objectFrame(object.belief);
  object.leaves = partitionLeaves(points, object.T_body_object, config.leaf_points, radiusLaw(config, config.leaf_gap));
  return object;
}

}  // namespace

std::vector<LocalEdge> connectObjects(const std::vector<GraphNode>& nodes, const CreationConfig& config) {
  std::vector<Vec3> means;
  means.reserve(nodes.size());
  for (const GraphNode& node : nodes) {
    means.push_back(node.belief->mean);
  }
  std::vector<LocalEdge> edges;
  double s1_max = 0;
  for (const auto& [a, b] : relativeNeighborhood(means)) {
    const double s1 = edgeDistance(*nodes[static_cast<std::size_t>(a)].belief,
                                   *nodes[static_cast<std::size_t>(b)].belief, config.sigma_floor);
    s1_max = std::max(s1_max, s1);
    edges.push_back({a, b, s1});
  }
  const double c = config.edge_geometry_share;
  for (LocalEdge& e : edges) {
    const double s2 = nodes[static_cast<std::size_t>(e.a)].label == nodes[static_cast<std::size_t>(e.b)].label ? 0 : 1;
    e.weight = (s1_max > 0 ? c * e.weight / s1_max : 0) + (1 - c) * s2;
  }
  return edges;
}

LocalGraph createLocalGraph(const Frame& frame, const Pose& T_map_body, const ClassTable& classes,
                            const Config& config) {
  Instances instances = segmentInstances(frame, T_map_body, classes, config);
  LocalGraph graph;
  graph.utime_us = frame.utime_us;
  graph.nonfinite_points = instances.nonfinite_points;
  graph.out_of_range_points = instances.out_of_range_points;
  graph.ignored_points = instances.ignored_points;
  graph.unknown_labels = instances.unknown_labels;
  graph.objects.reserve(instances.list.size());
  std::vector<GraphNode> nodes;
  for (const Instance& instance : instances.list) {
    const auto points = std::span(instances.points).subspan(instance.begin, instance.end - instance.begin);
    graph.objects.push_back(createObject(instance, points, config.creation));
    graph.objects.back().begin = instance.begin, graph.objects.back().end = instance.end;
  }
  graph.points = std::move(instances.points);
  for (const LocalObject& object : graph.objects) {
    nodes.push_back({object.label, &object.belief});
  }
  graph.edges = connectObjects(nodes, config.creation);
  return graph;
}

}  // namespace hgg
