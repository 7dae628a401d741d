#include <algorithm>
#include <hgg/regions_t.hpp>
#include <iterator>

#include "bus/codec.h"
#include "bus/wire.h"

namespace hgg {
namespace {

hgg::region_t makeRegion(const Region& region) {
  hgg::region_t out{};
  out.id = region.id;
  out.name = region.name;
  store(region.belief.mean, out.mean);
  std::copy_n(region.belief.cov.data(), 9, out.cov);  // symmetric: row-major is column-major
  out.kappa = region.belief.kappa;
  out.objects = region.objects;
  out.num_objects = static_cast<std::int32_t>(out.objects.size());
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

std::vector<std::uint8_t> encodeRegions(const RegionsUpdate& update) {
  hgg::regions_t message{};
  message.utime = update.utime_us;
  message.revision = update.revision;
  std::ranges::transform(update.found.regions, std::back_inserter(message.regions), makeRegion);
  message.num_regions = static_cast<std::int32_t>(message.regions.size());
  std::ranges::transform(update.found.edges, std::back_inserter(message.edges), makeEdge);
  message.num_edges = static_cast<std::int32_t>(message.edges.size());
  return encode(message);
}

}  // namespace hgg
