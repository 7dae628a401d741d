#include "map/whole_map.h"

#include <algorithm>

#include "core/se3.h"
#include "map/node_bytes.h"

namespace hgg {
namespace {

/// Pages that are held at a time. The ids of a page's nodes are nearly those of a stretch of the way, so that each page
/// is read little more than once.
constexpr std::size_t kHeldPages = 64;

}  // namespace

WholeMap::WholeMap(const Map& map, const PageReader& read) : map_(map), read_(read) { survey(); }

void WholeMap::note(const MapNode& node) {
  has_looks_ = has_looks_ || hgg::hasLooks(node);
  has_free_space_ = has_free_space_ || hgg::hasFreeSpace(node);
}

void WholeMap::survey() {
  for (const auto& [id, node] : map_.nodes()) {
    note(node);
  }
  if (map_.isWhole() && map_.graph().isSettled()) {
    edges_ = map_.graph().edges();
    return;
  }
  ObjectGraph graph = map_.graph();
  for (const KeyframeId id : map_.pagedOut()) {
    const MapPage* page = pageAt(id);
    if (page == nullptr) {
      return;
    }
    for (const MapNode& node : page->nodes) {
      note(node);
      away_.emplace_back(node.id, id);
      if (graph.hasModel() && isConfirmed(node)) {
        graph.put(node.id, node.label, node.belief);
      }
    }
  }
  std::ranges::sort(away_);
  graph.settle();
  edges_ = graph.edges();
}

const MapPage* WholeMap::pageAt(KeyframeId id) {
  if (const auto held = held_.find(id); held != held_.end()) {
    return &held->second;
  }
  Result<MapPage> page = read_ ? read_(id) : Result<MapPage>::fail("parts of the map are not in memory");
  if (!page) {
    error_ = page.error;
    return nullptr;
  }
  const Pose& T_map_keyframe = map_.keyframes().poses().at(static_cast<std::size_t>(id)).T_map_body;
  if (T_map_keyframe.matrix() != page->T_map_keyframe.matrix()) {
    const Pose move = orthonormalized(T_map_keyframe * page->T_map_keyframe.inverse());
    for (MapNode& node : page->nodes) {
      moveBy(move, map_.tileSize(), node);
    }
  }
  if (order_.size() == kHeldPages) {
    held_.erase(order_.front());
    order_.pop_front();
  }
  order_.push_back(id);
  return &held_.emplace(id, std::move(*page)).first->second;
}

const MapNode* WholeMap::findAway(NodeId id, KeyframeId keyframe) {
  const MapPage* page = pageAt(keyframe);
  if (page == nullptr) {
    return nullptr;
  }
  const auto node = std::ranges::lower_bound(page->nodes, id, {}, &MapNode::id);
  return node != page->nodes.end() && node->id == id ? &*node : nullptr;
}

}  // namespace hgg
