#include <algorithm>
#include <hgg/graph_update_t.hpp>
#include <iterator>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

hgg::object_t makeObject(const ObjectSummary& object) {
  hgg::object_t out;
  out.id = object.id;
  out.label = object.label;
  out.name = object.name;
  store(object.belief.mean, out.mean);
  std::copy_n(object.belief.cov.data(), 9, out.cov);  // symmetric: row-major is column-major
  out.kappa = object.belief.kappa;
  out.stuff = object.stuff;
  out.existence = object.existence;
  out.class_probability = object.class_probability;
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
  std::transform(update.objects.begin(), update.objects.end(), std::back_inserter(message.objects), makeObject);
  message.num_objects = static_cast<std::int32_t>(message.objects.size());
  message.removed = update.removed;
  message.num_removed = static_cast<std::int32_t>(message.removed.size());
  std::transform(update.edges.begin(), update.edges.end(), std::back_inserter(message.edges), makeEdge);
  message.num_edges = static_cast<std::int32_t>(message.edges.size());
  return encode(message);
}

}  // namespace hgg
