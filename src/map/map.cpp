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
  std::ranges::set_union(first.left, second.left, std::back_inserter(both.left));
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
    if (changed_.is_tracked) {
      changed_.keyframes.insert(id);
    }
    for (BetweenConstraint& constraint : update.keyframe->constraints) {
      constraint.b = id;
      keyframes_.connect(constraint);
    }
    pose_covariances_.add(keyframes_);
    keyframe_places_.insert(id, update.keyframe->pose.T_map_body.translation());
    findActive(id, delta);
  } else if (update.taken_up >= 0) {
    keyframes_.takeUp(update.taken_up);
    findActive(update.taken_up, delta);
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
    touch(node.anchor);
    addPlaceView(node.classes, evidence.view, node.label);
    delta.changed.push_back(evidence.id);
  }
  for (MapNode& node : update.created) {
    node.id = next_id_++;
    node.anchor = keyframes_.current();
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
      keyframe_places_.move(keyframe_places_.find(id), T_map_body.translation());
      if (const int place = page_places_.find(id); place >= 0) {
        page_places_.move(place, T_map_body.translation());
        paged_out_.at(id).was_moved = true;
      }
      if (changed_.is_tracked) {
        changed_.keyframes.insert(id);
      }
    }
  }
  std::ranges::sort(moves, {}, [](const auto& m) { return m.first; });
  moveNodes(moves, delta);
  if (delta.moved.size() > kMovedAtOnce) {
    graph_.postpone(keyframes_.currentPose().T_map_body.translation());
  } else {
    delta.rewired = graph_.refresh(ObjectGraph::Postponed::kLeave);
    std::erase_if(delta.rewired, [&](NodeId id) { return std::ranges::binary_search(delta.moved, id); });
  }
  if (correction.is_measured || correction.loosened) {
    changed_.constraints = 0;
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
  findActive(keyframes_.current(), delta);
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
  const TileKey before{node.label, node.tile};
  moveBy(move, tile_size_, node);
  const bool is_renamed = node.tile != before.tile;
  if (is_renamed) {
    unindexTile(before, node.id);
    indexTile(node);
  }
  means_.move(means_.find(node.id), node.belief.mean);
  graph_.move(node.id, node.belief);
  return is_renamed;
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
    } else if (before[k] && !active_[k]) {
      missed(static_cast<KeyframeId>(k));
    }
  }
  std::sort(delta.reactivated.begin(), delta.reactivated.end());
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

double Map::megabytesOf(std::size_t nodes, std::size_t leaves) {
  // A tree node, its index entries and its class views cost about 150 B beside the payload.
  return static_cast<double>(nodes * (sizeof(MapNode) + 150) + leaves * sizeof(Leaf)) / 1e6;
}

double Map::megabytes() const {
  constexpr std::size_t kGraphBytes = 300;  // place and edges in the object graph
  const std::size_t bytes = graph_.size() * kGraphBytes +
                            keyframes_.poses().size() * (sizeof(TimedPose) + sizeof(Mat6)) +
                            keyframes_.edges().size() * (sizeof(BetweenConstraint) + 16);
  return megabytesOf(nodes_.size(), leaf_count_) + static_cast<double>(bytes) / 1e6;
}

Map Map::restore(std::vector<MapNode> nodes, KeyframeGraph keyframes, std::map<ClassId, std::string> names,
                 std::int64_t revision, NodeId next_id) {
  Map map;
  map.keyframes_ = std::move(keyframes);
  map.pose_covariances_.recompute(map.keyframes_);
  for (KeyframeId id = 0; id <= map.keyframes_.last(); ++id) {
    map.keyframe_places_.insert(id, map.keyframes_.poses()[static_cast<std::size_t>(id)].T_map_body.translation());
  }
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

void Map::unindexTile(const TileKey& key, NodeId id) {
  const auto entry = tiles_.find(key);
  std::erase(entry->second, id);
  if (entry->second.empty()) {
    tiles_.erase(entry);
  }
}

void Map::insert(MapNode node) {
  touch(node.anchor);
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
  touch(node.anchor);
  means_.remove(means_.find(id));
  if (node.stuff) {
    unindexTile({node.label, node.tile}, node.id);
  }
  if (node.anchor >= 0) {
    std::erase(anchored_[static_cast<std::size_t>(node.anchor)], id);
  }
  leaf_count_ -= leavesOf(node).size();
  nodes_.erase(it);
}

}  // namespace hgg
