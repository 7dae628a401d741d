#include "creation/object_graph.h"

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
  std::vector<Vec3> means;
  for (const Instance& instance : instances.list) {
    const auto points = std::span(instances.points).subspan(instance.begin, instance.end - instance.begin);
    graph.objects.push_back(createObject(instance, points, config.creation));
    graph.objects.back().begin = instance.begin, graph.objects.back().end = instance.end;
  }
  graph.small.reserve(instances.small.size());
  for (const Instance& instance : instances.small) {
    graph.small.push_back(
        {instance.label, beliefOf(std::span(instances.points).subspan(instance.begin, instance.end - instance.begin))});
  }
  graph.points = std::move(instances.points);
  for (const LocalObject& object : graph.objects) {
    means.push_back(object.belief.mean);
  }
  graph.edges = relativeNeighborhood(means);
  return graph;
}

}  // namespace hgg
