#include "map/map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/se3.h"
#include "map/tentative.h"

namespace hgg {
namespace {

constexpr int kNeighbours = 8;

/// What a correction has moved is taken into the object graph at once up to this many nodes, a few milliseconds' work.
constexpr std::size_t kMovedAtOnce = 300;

}  // namespace

MapDelta joined(MapDelta first, const MapDelta& second) {
  if (second.revision == 0) {
    return first;
  }
  MapDelta both;
  both.revision = second.revision;
  std::ranges::set_union(first.changed, second.changed, std::back_inserter(both.changed));
  std::ranges::set_union(first.moved, second.moved, std::back_inserter(both.moved));
  std::ranges::set_union(first.removed, second.removed, std::back_inserter(both.removed));
  std::ranges::set_union(first.rewired, second.rewired, std::back_inserter(both.rewired));
  const auto isRemoved = [&](NodeId id) { return std::ranges::binary_search(both.removed, id); };
  std::erase_if(both.changed, isRemoved);
  const auto isChanged = [&](NodeId id) { return isRemoved(id) || std::ranges::binary_search(both.changed, id); };
  std::erase_if(both.moved, isChanged);
  std::erase_if(both.rewired, [&](NodeId id) { return isChanged(id) || std::ranges::binary_search(both.moved, id); });
  return both;
}

MapDelta Map::apply(MapUpdate update) {
  MapDelta delta;
  delta.revision = update.is_sequel ? revision_ : ++revision_;
  if (update.keyframe) {
    const KeyframeId id = keyframes_.add(update.keyframe->pose);
    anchored_.emplace_back();
    for (BetweenConstraint& constraint : update.keyframe->constraints) {
      constraint.b = id;
      keyframes_.connect(constraint);
    }
    pose_covariances_.add(keyframes_);
    findActive(id, delta);
  }
  for (const NodeId id : update.removed) {
    erase(id);
    graph_.remove(id);
  }
  for (MapNode& node : update.changed) {
    delta.changed.push_back(node.id);
    erase(node.id);
    insert(std::move(node));
  }
  for (const ClassEvidence& evidence : update.evidence) {
    MapNode& node = nodes_.at(evidence.id);
    addPlaceView(node.classes, evidence.view, node.label);
    delta.changed.push_back(evidence.id);
  }
  for (MapNode& node : update.created) {
    node.id = next_id_++;
    node.anchor = keyframes_.last();
    delta.changed.push_back(node.id);
    insert(std::move(node));
  }
  if (update.tentative) {
    tentative_ = std::move(*update.tentative);
  }
  delta.removed = std::move(update.removed);
  std::sort(delta.changed.begin(), delta.changed.end());
  std::sort(delta.removed.begin(), delta.removed.end());
  for (const NodeId id : delta.changed) {
    enterGraph(*find(id));
  }
  using Postponed = ObjectGraph::Postponed;
  delta.rewired = graph_.refresh(update.is_sequel ? Postponed::kLeave : Postponed::kTakeSome);  // once a frame
  std::erase_if(delta.rewired, [&](NodeId id) { return std::ranges::binary_search(delta.changed, id); });
  std::erase_if(delta.reactivated, [&](NodeId id) { return find(id) == nullptr; });
  return delta;
}

MapDelta Map::apply(const MapCorrection& correction) {
  MapDelta delta;
  delta.revision = revision_;
  KeyframeMoves moves;
  for (const auto& [id, T_map_body] : correction.moved) {
    const Pose& T_before = keyframes_.poses().at(static_cast<std::size_t>(id)).T_map_body;
    if (T_map_body.matrix() != T_before.matrix()) {  // T T^-1 is the identity only up to rounding
      moves.emplace_back(id, orthonormalized(T_map_body * T_before.inverse()));
      keyframes_.move(id, T_map_body);
    }
  }
  std::ranges::sort(moves, {}, [](const auto& m) { return m.first; });
  moveNodes(moves, delta);
  if (delta.moved.size() > kMovedAtOnce) {
    graph_.postpone(keyframes_.poses().back().T_map_body.translation());
  } else {
    delta.rewired = graph_.refresh(ObjectGraph::Postponed::kLeave);
    std::erase_if(delta.rewired, [&](NodeId id) { return std::ranges::binary_search(delta.moved, id); });
  }
  if (correction.is_measured) {
    keyframes_.remeasure(moves);
  }
  if (correction.loosened) {
    keyframes_.loosen(*correction.loosened);
  }
  for (const BetweenConstraint& loop : correction.loops) {
    keyframes_.connect(loop);
  }
  if (!correction.loops.empty()) {
    pose_covariances_.recompute(keyframes_);
  }
  findActive(keyframes_.last(), delta);
  return delta;
}

void Map::moveNodes(const KeyframeMoves& moves, MapDelta& delta) {
  std::vector<std::pair<NodeId, const Pose*>> moved;
  for (const auto& [id, move] : moves) {
    for (const NodeId node : anchored_[static_cast<std::size_t>(id)]) {
      moved.emplace_back(node, &move);
    }
  }
  std::sort(moved.begin(), moved.end());
  delta.moved.reserve(moved.size());
  auto node = nodes_.begin();
  for (const auto& [id, move] : moved) {
    // The next one is nearly always a neighbour, which is nearer to hand than the root of a large tree.
    for (int step = 0; step < kNeighbours && node->first < id; ++step) {
      ++node;
    }
    node = node->first == id ? node : nodes_.find(id);
    if (moveNode(node->second, *move)) {
      delta.colliding.push_back(id);
    }
    delta.moved.push_back(id);
  }
  moveThings(tentative_, moves);
  const auto isAlone = [&](NodeId id) {
    const MapNode& stuff = *find(id);
    return tiles_.at({stuff.label, stuff.tile}).size() == 1;
  };
  std::erase_if(delta.colliding, isAlone);
}

bool Map::moveNode(MapNode& node, const Pose& move) {
  const Belief belief = transform(move, node.belief);
  const Tile tile = node.stuff && tile_size_ > 0 ? tileOf(belief.mean, tile_size_) : node.tile;
  const bool is_renamed = tile != node.tile;
  if (is_renamed) {
    unindexTile(node);
  }
  node.belief = belief;
  node.T_map_object = orthonormalized(move * node.T_map_object);
  node.tile = tile;
  if (is_renamed) {
    indexTile(node);
  }
  means_.move(means_.find(node.id), belief.mean);
  graph_.move(node.id, belief);
  return is_renamed;
}

std::vector<MapPage> Map::pageOut(const std::vector<KeyframeId>& ids, MapDelta& delta) {
  std::vector<MapPage> pages;
  for (const KeyframeId id : ids) {
    const Pose& T_map_keyframe = keyframes_.poses().at(static_cast<std::size_t>(id)).T_map_body;
    PagedOut bounds{T_map_keyframe, 0, isActive(id)};
    MapPage& page = pages.emplace_back(MapPage{id, {}});
    std::vector<NodeId> nodes = anchoredTo(id);
    std::ranges::sort(nodes);
    for (const NodeId node : nodes) {
      bounds.radius = std::max(bounds.radius, (find(node)->belief.mean - T_map_keyframe.translation()).norm());
      page.nodes.push_back(*find(node));
      erase(node);
      graph_.remove(node);
    }
    paged_out_[id] = bounds;
  }
  delta.revision = revision_;
  delta.rewired = graph_.refresh(ObjectGraph::Postponed::kLeave);
  return pages;
}

MapDelta Map::pageIn(std::vector<MapPage> pages) {
  MapDelta delta;
  delta.revision = revision_;
  for (MapPage& page : pages) {
    const PagedOut bounds = paged_out_.at(page.keyframe);
    paged_out_.erase(page.keyframe);
    for (MapNode& node : page.nodes) {
      const NodeId id = node.id;
      insert(std::move(node));
      enterGraph(*find(id));
      delta.changed.push_back(id);
      if (!bounds.was_active && isActive(page.keyframe)) {
        delta.reactivated.push_back(id);
      }
    }
    const Pose& T_map_keyframe = keyframes_.poses()[static_cast<std::size_t>(page.keyframe)].T_map_body;
    if (T_map_keyframe.matrix() != bounds.T_map_keyframe.matrix()) {
      MapDelta moved;
      moveNodes({{page.keyframe, orthonormalized(T_map_keyframe * bounds.T_map_keyframe.inverse())}}, moved);
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

std::vector<KeyframeId> Map::pagedOutNear(const Vec3& centre, double radius) const {
  std::vector<KeyframeId> near;
  for (const auto& [id, bounds] : paged_out_) {
    const Vec3& p_map = keyframes_.poses()[static_cast<std::size_t>(id)].T_map_body.translation();
    if ((p_map - centre).norm() <= radius + bounds.radius) {
      near.push_back(id);
    }
  }
  return near;
}

void Map::startAt(KeyframeId id) {
  MapDelta unpublished;
  findActive(id, unpublished);
}

void Map::findActive(KeyframeId from, MapDelta& delta) {
  if (!std::isfinite(drift_reach_) || from < 0) {
    return;  // all are
  }
  const std::vector<Drift> drift = keyframes_.driftFrom(from, drift_reach_);
  std::vector<bool> before = std::move(active_);
  before.resize(drift.size(), true);
  active_.assign(drift.size(), false);
  for (std::size_t k = 0; k < drift.size(); ++k) {
    active_[k] = drift[k].position >= 0;
    if (active_[k] && !before[k]) {
      delta.reactivated.insert(delta.reactivated.end(), anchored_[k].begin(), anchored_[k].end());
    }
  }
  std::sort(delta.reactivated.begin(), delta.reactivated.end());
  for (auto& [id, page] : paged_out_) {
    page.was_active = page.was_active && isActive(id);  // else it is reactivated when it comes back
  }
}

bool Map::isActive(KeyframeId id) const {
  const auto k = static_cast<std::size_t>(id);
  return id < 0 || k >= active_.size() || active_[k];
}

const MapNode* Map::find(NodeId id) const {
  const auto it = nodes_.find(id);
  return it == nodes_.end() ? nullptr : &it->second;
}

GeometryBlock Map::geometry(NodeId id) const {
  const MapNode* const node = find(id);
  if (node == nullptr || node->geometry == nullptr) {
    std::abort();  // a caller did not bring back what it reads
  }
  return node->geometry;
}

const MapNode* Map::findTile(ClassId label, const Tile& tile) const {
  const auto it = tiles_.find({label, tile});
  if (it == tiles_.end()) {
    return nullptr;
  }
  const auto active = std::ranges::find_if(it->second, [&](NodeId id) { return isActive(*find(id)); });
  return active == it->second.end() ? nullptr : find(*active);
}

std::vector<NodeId> Map::activeOfTile(ClassId label, const Tile& tile) const {
  const auto it = tiles_.find({label, tile});
  std::vector<NodeId> ids = it == tiles_.end() ? std::vector<NodeId>() : it->second;
  std::erase_if(ids, [&](NodeId id) { return !isActive(*find(id)); });
  return ids;
}

std::vector<NodeId> Map::near(const Vec3& centre, double radius) const {
  std::vector<NodeId> ids = nearAnywhere(centre, radius);
  std::erase_if(ids, [&](NodeId id) { return !isActive(*find(id)); });
  return ids;
}

std::vector<NodeId> Map::nearAnywhere(const Vec3& centre, double radius) const { return means_.near(centre, radius); }

void Map::setEdgeModel(const EdgeModel& model) {
  graph_.setModel(model);
  for (const auto& [id, node] : nodes_) {
    enterGraph(node);
  }
  graph_.settle();
}

void Map::enterGraph(const MapNode& node) {
  if (!graph_.hasModel()) {
    return;
  }
  if (isConfirmed(node)) {
    graph_.put(node.id, node.label, node.belief);
  } else {
    graph_.remove(node.id);
  }
}

std::size_t Map::confirmedCount() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(nodes_, [](const auto& entry) { return isConfirmed(entry.second); }));
}

double Map::megabytes() const {
  // A tree node, its index entries and its class views cost about 150 B beside the payload, and its place and edges in
  // the object graph as much twice over.
  constexpr std::size_t kGraphBytes = 300;
  const std::size_t bytes = nodes_.size() * (sizeof(MapNode) + 150) + graph_.size() * kGraphBytes +
                            leaf_count_ * sizeof(Leaf) +
                            keyframes_.poses().size() * (sizeof(TimedPose) + sizeof(Mat6)) +
                            keyframes_.edges().size() * (sizeof(BetweenConstraint) + 16);
  return static_cast<double>(bytes) / 1e6;
}

Map Map::restore(std::vector<MapNode> nodes, KeyframeGraph keyframes, std::map<ClassId, std::string> names,
                 std::int64_t revision, NodeId next_id) {
  Map map;
  map.keyframes_ = std::move(keyframes);
  map.pose_covariances_.recompute(map.keyframes_);
  map.anchored_.resize(map.keyframes_.poses().size());
  map.next_id_ = std::max<NodeId>(next_id, 1);
  for (MapNode& node : nodes) {
    map.next_id_ = std::max(map.next_id_, node.id + 1);
    map.insert(std::move(node));
  }
  map.class_names_ = std::move(names);
  map.revision_ = revision;
  return map;
}

void Map::indexTile(const MapNode& node) {
  if (node.stuff) {
    std::vector<NodeId>& ids = tiles_[{node.label, node.tile}];
    ids.insert(std::ranges::upper_bound(ids, node.id), node.id);
  }
}

void Map::unindexTile(const MapNode& node) {
  if (node.stuff) {
    const auto entry = tiles_.find({node.label, node.tile});
    std::erase(entry->second, node.id);
    if (entry->second.empty()) {
      tiles_.erase(entry);
    }
  }
}

void Map::insert(MapNode node) {
  means_.insert(node.id, node.belief.mean);
  indexTile(node);
  leaf_count_ += leavesOf(node).size();
  if (node.anchor >= 0) {
    anchored_.at(static_cast<std::size_t>(node.anchor)).push_back(node.id);
  }
  const NodeId id = node.id;
  if (!nodes_.emplace(id, std::move(node)).second) {
    std::abort();  // a caller inserted an id twice
  }
}

void Map::erase(NodeId id) {
  const auto it = nodes_.find(id);
  if (it == nodes_.end()) {
    std::abort();  // a caller changed or removed a node the map does not have
  }
  const MapNode& node = it->second;
  means_.remove(means_.find(id));
  unindexTile(node);
  if (node.anchor >= 0) {
    std::erase(anchored_[static_cast<std::size_t>(node.anchor)], id);
  }
  leaf_count_ -= leavesOf(node).size();
  nodes_.erase(it);
}

}  // namespace hgg
