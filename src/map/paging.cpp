#include "map/paging.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace hgg {

MapDelta bringBack(Map& map, const PageStore& store, const Vec3& centre, double radius) {
  MapDelta all;
  all.revision = map.revision();
  for (const KeyframeId id : map.pagedOutNear(centre, radius)) {
    const MapDelta delta = map.pageIn(store.take(id));
    std::ranges::copy(delta.moved, std::back_inserter(all.moved));
    std::ranges::copy(delta.reactivated, std::back_inserter(all.reactivated));
    std::ranges::copy(delta.colliding, std::back_inserter(all.colliding));
    std::ranges::copy(delta.rewired, std::back_inserter(all.rewired));
  }
  for (std::vector<NodeId>* ids : {&all.moved, &all.reactivated, &all.colliding, &all.rewired}) {
    std::ranges::sort(*ids);
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
  }
  return all;
}

void pageOutBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending) {
  if (!std::isfinite(store.keep_radius)) {
    return;
  }
  const auto mustStay = [&](NodeId id) {
    return std::ranges::binary_search(pending, id) || (map.find(id)->belief.mean - centre).norm() <= store.keep_radius;
  };
  for (KeyframeId id = 0; id < map.keyframes().last(); ++id) {
    const std::vector<NodeId>& nodes = map.anchoredTo(id);
    if (!nodes.empty() && std::ranges::none_of(nodes, mustStay)) {
      store.put(map.pageOut(id));
    }
  }
}

}  // namespace hgg
