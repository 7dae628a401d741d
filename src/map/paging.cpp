#include "map/paging.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hgg {

MapDelta bringBack(Map& map, const PageStore& store, const Vec3& centre, double radius) {
  std::vector<MapPage> pages;
  for (const KeyframeId id : map.pagedOutNear(centre, radius)) {
    pages.push_back(store.take(id));
  }
  return pages.empty() ? MapDelta{} : map.pageIn(std::move(pages));
}

MapDelta pageOutBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending) {
  MapDelta delta;
  if (!std::isfinite(store.keep_radius)) {
    return delta;
  }
  const auto mustStay = [&](NodeId id) {
    return std::ranges::binary_search(pending, id) || (map.find(id)->belief.mean - centre).norm() <= store.keep_radius;
  };
  std::vector<KeyframeId> leaving;
  for (KeyframeId id = 0; id < map.keyframes().last(); ++id) {
    const std::vector<NodeId>& nodes = map.anchoredTo(id);
    if (!nodes.empty() && std::ranges::none_of(nodes, mustStay)) {
      leaving.push_back(id);
    }
  }
  if (!leaving.empty()) {
    for (MapPage& page : map.pageOut(leaving, delta)) {
      store.put(std::move(page));
    }
  }
  return delta;
}

}  // namespace hgg
