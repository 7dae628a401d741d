#include <algorithm>
#include <hgg/graph_update_t.hpp>
#include <iterator>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

void storeClasses(const ClassWeights& classes, hgg::object_t& out) {
  out.num_classes = static_cast<std::int32_t>(classes.size());
  out.class_ids.reserve(classes.size());
  out.class_probabilities.reserve(classes.size());
  for (const auto& [label, probability] : classes) {
    out.class_ids.push_back(label);
    out.class_probabilities.push_back(probability);
  }
}

hgg::object_t makeObject(const ObjectSummary& object) {
  hgg::object_t out{};  // velocity, fragment: zero means not known
  out.id = object.id;
  out.label = object.label;
  out.name = object.name;
  store(object.belief.mean, out.mean);
  std::copy_n(object.belief.cov.data(), 9, out.cov);  // symmetric: row-major is column-major
  out.kappa = object.belief.kappa;
  Eigen::Map<Eigen::Matrix3f>(out.position_cov) = object.position_cov.cast<float>();
  Eigen::Map<Eigen::Matrix3f>(out.relative_cov) = object.relative_cov.cast<float>();
  out.anchor = object.anchor;
  out.region = kNone;
  out.stuff = object.stuff;
  out.existence = object.existence;
  out.class_probability = object.class_probability;
  storeClasses(object.classes, out);
  out.dynamic = object.motion.has_value();
  if (object.motion) {
    Eigen::Map<Eigen::Vector3f>(out.velocity) = object.motion->velocity.cast<float>();
    Eigen::Map<Eigen::Matrix3f>(out.velocity_cov) = object.motion->velocity_cov.cast<float>();
  }
  out.views = object.views;
  out.leaves = object.leaves;
  out.first_us = object.first_us;
  out.last_us = object.last_us;
  return out;
}

hgg::edge_t makeEdge(const Edge& edge) {
  hgg::edge_t out;
  out.a = edge.a;
  out.b = edge.b;
  out.weight = edge.weight;
  return out;
}

}  // namespace

std::vector<std::uint8_t> encodeGraphUpdate(const GraphUpdate& update) {
  hgg::graph_update_t message{};
  message.utime = update.utime_us;
  message.revision = update.revision;
  message.complete = update.complete;
  message.num_parts = 1;
  message.objects.reserve(update.objects.size());
  std::transform(update.objects.begin(), update.objects.end(), std::back_inserter(message.objects), makeObject);
  message.num_objects = static_cast<std::int32_t>(message.objects.size());
  message.removed = update.removed;
  message.num_removed = static_cast<std::int32_t>(message.removed.size());
  std::transform(update.edges.begin(), update.edges.end(), std::back_inserter(message.edges), makeEdge);
  message.num_edges = static_cast<std::int32_t>(message.edges.size());
  return encode(message);
}

}  // namespace hgg
