// What of a map is in memory, and what of it has changed.
#include <algorithm>
#include <limits>
#include <utility>

#include "core/se3.h"
#include "map/map.h"

namespace hgg {

KeyframeId Map::keyframeAt(const Pose& T_map_body) const {
  constexpr double kReach = 3;  // m, beyond which none is at a pose
  KeyframeId nearest = -1;
  double distance = std::numeric_limits<double>::infinity();
  for (const PointIndex::Id found : keyframe_places_.near(T_map_body.translation(), kReach)) {
    const auto id = static_cast<KeyframeId>(found);
    const Vec3& p_map = keyframes_.poses()[static_cast<std::size_t>(id)].T_map_body.translation();
    const double away = (p_map - T_map_body.translation()).norm();
    if (isActive(id) && keyframes_.isAt(id, T_map_body) && away < distance) {
      nearest = id, distance = away;
    }
  }
  return nearest;
}

std::vector<KeyframeId> Map::keyframesNear(const Vec3& centre, double radius) const {
  std::vector<KeyframeId> near;
  for (const PointIndex::Id id : keyframe_places_.near(centre, radius)) {
    near.push_back(static_cast<KeyframeId>(id));
  }
  return near;
}

MapPage Map::pageOf(KeyframeId id) const {
  MapPage page{id, Pose::Identity(), {}};
  if (id >= 0) {
    page.T_map_keyframe = keyframes_.poses().at(static_cast<std::size_t>(id)).T_map_body;
    std::vector<NodeId> nodes = anchoredTo(id);
    std::ranges::sort(nodes);
    for (const NodeId node : nodes) {
      page.nodes.push_back(*find(node));
    }
    return page;
  }
  for (const auto& [node_id, node] : nodes_) {
    if (node.anchor < 0) {
      page.nodes.push_back(node);
    }
  }
  return page;
}

std::vector<MapPage> Map::pageOut(const std::vector<KeyframeId>& ids, MapDelta& delta) {
  std::vector<MapPage> pages;
  for (const KeyframeId id : ids) {
    const MapPage& page = pages.emplace_back(pageOf(id));
    const Vec3 centre = page.T_map_keyframe.translation();
    double reach = 0;
    for (const MapNode& node : page.nodes) {
      reach = std::max(reach, (node.belief.mean - centre).norm());
      delta.left.push_back(node.id);
      erase(node.id);
      graph_.remove(node.id);
    }
    changed_.anchors.erase(id);
    paged_out_[id] = {isActive(id), false};
    page_places_.setReach(page_places_.insert(id, centre), reach);
  }
  std::ranges::sort(delta.left);
  delta.revision = revision_;
  delta.rewired = graph_.refresh(ObjectGraph::Postponed::kLeave);
  return pages;
}

MapDelta Map::pageIn(std::vector<MapPage> pages) {
  MapDelta delta;
  delta.revision = revision_;
  for (MapPage& page : pages) {
    const PagedOut state = paged_out_.at(page.keyframe);
    giveUp(page.keyframe);
    for (MapNode& node : page.nodes) {
      const NodeId id = node.id;
      insert(std::move(node));
      enterGraph(*find(id));
      delta.changed.push_back(id);
      if (!state.was_active && isActive(page.keyframe)) {
        delta.reactivated.push_back(id);
      }
    }
    const Pose& T_map_keyframe = keyframes_.poses()[static_cast<std::size_t>(page.keyframe)].T_map_body;
    if (T_map_keyframe.matrix() != page.T_map_keyframe.matrix()) {
      MapDelta moved;
      moveNodes({{page.keyframe, orthonormalized(T_map_keyframe * page.T_map_keyframe.inverse())}}, moved);
    }
  }
  std::ranges::sort(delta.changed);
  std::ranges::sort(delta.reactivated);
  for (const NodeId id : delta.changed) {
    const MapNode& node = *find(id);
    if (node.stuff && tiles_.at({node.label, node.tile}).size() > 1) {
      delta.colliding.push_back(id);
    }
  }
  delta.rewired = graph_.refresh(ObjectGraph::Postponed::kLeave);
  std::erase_if(delta.rewired, [&](NodeId id) { return std::ranges::binary_search(delta.changed, id); });
  return delta;
}

void Map::giveUp(KeyframeId id) {
  paged_out_.erase(id);
  if (const int place = page_places_.find(id); place >= 0) {
    page_places_.remove(place);
  }
}

void Map::missed(KeyframeId id) {
  if (const auto page = paged_out_.find(id); page != paged_out_.end()) {
    page->second.was_active = false;  // reactivated when it comes back
  }
}

std::vector<KeyframeId> Map::pagedOut() const {
  std::vector<KeyframeId> ids;
  for (const auto& [id, page] : paged_out_) {
    ids.push_back(id);
  }
  return ids;
}

std::vector<KeyframeId> Map::pagedOutNear(const Vec3& centre, double radius) const {
  std::vector<KeyframeId> near;
  page_places_.reaching(centre, radius, [&](int k) { near.push_back(static_cast<KeyframeId>(page_places_.idOf(k))); });
  std::ranges::sort(near);
  return near;
}

std::vector<KeyframeId> Map::pagedOutStale() const {
  std::vector<KeyframeId> stale;
  for (const auto& [id, page] : paged_out_) {
    if (page.was_moved || (!page.was_active && isActive(id))) {
      stale.push_back(id);
    }
  }
  return stale;
}

void Map::touch(KeyframeId anchor) {
  if (changed_.is_tracked) {
    changed_.anchors.insert(anchor);
  }
}

void Map::trackChanges() { changed_.is_tracked = true; }

MapChanges Map::takeChanges(bool all) {
  MapChanges changes;
  changes.head = {class_names_, tile_size_, odometry_delay_us_, revision_, next_id_, graph_.model()};
  if (all) {
    changed_.constraints = 0;
    for (KeyframeId id = -1; id <= keyframes_.last(); ++id) {
      changed_.keyframes.insert(id);
      if (!paged_out_.contains(id)) {
        changed_.anchors.insert(id);
      }
    }
  }
  for (const KeyframeId id : std::exchange(changed_.anchors, {})) {
    if (!paged_out_.contains(id)) {
      changes.pages.push_back(pageOf(id));
    }
  }
  for (const KeyframeId id : std::exchange(changed_.keyframes, {})) {
    if (id >= 0) {
      changes.keyframes.emplace_back(id, keyframes_.poses()[static_cast<std::size_t>(id)]);
    }
  }
  changes.first_constraint = changed_.constraints;
  const std::vector<BetweenConstraint>& edges = keyframes_.edges();
  changes.constraints.assign(edges.begin() + static_cast<std::ptrdiff_t>(changed_.constraints), edges.end());
  changed_.constraints = edges.size();
  return changes;
}

}  // namespace hgg
