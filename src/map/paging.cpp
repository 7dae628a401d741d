#include "map/paging.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "map/leaf_grid.h"

namespace hgg {
namespace {

/// Of the budget: so much is left when pages have left.
constexpr double kLeftShare = 0.9;
/// Leaves that are made coarser become so many times as wide.
constexpr double kCoarser = 4;
/// A node with fewer leaves gives them up.
constexpr std::size_t kFewLeaves = 4;

double megabytesOf(const Map& map, const PageStore& store) {
  return map.megabytes() + (store.megabytes ? store.megabytes() : 0);
}

/// Keyframes whose nodes may leave, with the distance of the nearest one.
std::vector<std::pair<double, KeyframeId>> leavable(const Map& map, const PageStore& store, const Vec3& centre,
                                                    const std::vector<NodeId>& pending) {
  std::vector<std::pair<double, KeyframeId>> found;
  for (KeyframeId id = 0; id < map.keyframes().last(); ++id) {
    if (id == map.keyframes().current()) {
      continue;  // the next frames go on with it
    }
    double nearest = std::numeric_limits<double>::infinity();
    for (const NodeId node : map.anchoredTo(id)) {
      const bool is_pending = std::ranges::binary_search(pending, node);
      nearest = std::min(nearest, is_pending ? 0 : (map.find(node)->belief.mean - centre).norm());
    }
    if (!map.anchoredTo(id).empty() && nearest > store.keep_radius) {
      found.emplace_back(nearest, id);
    }
  }
  return found;
}

/// Bytes of memory that leave with the nodes of a keyframe, MB.
double megabytesOf(const Map& map, KeyframeId id) {
  std::size_t leaves = 0;
  for (const NodeId node : map.anchoredTo(id)) {
    leaves += leavesOf(*map.find(node)).size();
  }
  return Map::megabytesOf(map.anchoredTo(id).size(), leaves);
}

}  // namespace

MapDelta bringBack(Map& map, const PageStore& store, const Vec3& centre, double radius) {
  std::vector<MapPage> pages;
  std::vector<KeyframeId> ids = map.pagedOutNear(centre, radius);
  if (ids.size() > store.most_at_once) {
    const auto distance = [&](KeyframeId id) {
      return (map.keyframes().poses()[static_cast<std::size_t>(id)].T_map_body.translation() - centre).squaredNorm();
    };
    std::ranges::stable_sort(ids, {}, distance);
    std::for_each(ids.begin() + static_cast<std::ptrdiff_t>(store.most_at_once), ids.end(),
                  [&](KeyframeId id) { map.missed(id); });
    ids.resize(store.most_at_once);
    std::ranges::sort(ids);
  }
  for (const KeyframeId id : ids) {
    TakenPage taken = store.take(id);
    if (taken.page) {
      pages.push_back(std::move(*taken.page));
    } else if (taken.is_lost) {
      map.giveUp(id);
    } else {
      map.missed(id);
    }
  }
  return pages.empty() ? MapDelta{} : map.pageIn(std::move(pages));
}

MapDelta pageOutBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending,
                       std::size_t most) {
  MapDelta delta;
  double excess = megabytesOf(map, store) - store.budget_mb;
  if (!store.isOpen() || excess <= 0) {
    return delta;
  }
  excess += (1 - kLeftShare) * store.budget_mb;
  std::vector<std::pair<double, KeyframeId>> far = leavable(map, store, centre, pending);
  std::ranges::sort(far, std::greater<>());
  std::vector<KeyframeId> leaving;
  for (const auto& [distance, id] : far) {
    if (leaving.size() == most || excess <= 0) {
      break;
    }
    leaving.push_back(id);
    excess -= megabytesOf(map, id);
  }
  std::ranges::sort(leaving);
  if (!leaving.empty()) {
    for (MapPage& page : map.pageOut(leaving, delta)) {
      store.put(std::move(page));
    }
  }
  return delta;
}

MapDelta dropDetailBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending,
                          double leaf_size, std::size_t most) {
  if (!store.isOpen() || megabytesOf(map, store) <= store.budget_mb) {
    return {};
  }
  MapUpdate update;
  update.is_sequel = true;
  std::size_t pages = 0;
  for (const auto& [distance, id] : leavable(map, store, centre, pending)) {
    const std::size_t before = update.changed.size();
    for (const NodeId node_id : map.anchoredTo(id)) {
      MapNode node = *map.find(node_id);
      if (leavesOf(node).empty()) {
        continue;
      }
      std::vector<Belief> fine;
      std::ranges::transform(leavesOf(node), std::back_inserter(fine), unpackLeaf);
      Leaves coarse = fuseLeaves({}, fine, Pose::Identity(), kCoarser * leaf_size);
      const bool is_coarse = coarse.size() < kFewLeaves || 2 * coarse.size() > leavesOf(node).size();
      node.geometry = shareLeaves(is_coarse ? Leaves() : std::move(coarse));
      update.changed.push_back(std::move(node));
    }
    pages += update.changed.size() > before ? 1 : 0;
    if (pages == most) {
      break;
    }
  }
  return update.changed.empty() ? MapDelta{} : map.apply(std::move(update));
}

}  // namespace hgg
