#include "traversability/leaf_copy.h"

#include <utility>

namespace hgg {

LeafChanges changesOf(const Map& map, std::span<const NodeId> touched) {
  LeafChanges changes;
  for (const NodeId id : touched) {
    if (const MapNode* node = map.find(id)) {
      changes.nodes.push_back(*node);
    } else {
      changes.removed.push_back(id);
    }
  }
  changes.keyframes = map.keyframes().poses();
  return changes;
}

LeafChanges allOf(const Map& map) {
  LeafChanges changes;
  changes.nodes.reserve(map.nodes().size());
  for (const auto& [id, node] : map.nodes()) {
    changes.nodes.push_back(node);
  }
  changes.keyframes = map.keyframes().poses();
  return changes;
}

void LeafCopy::apply(LeafChanges changes) {
  for (MapNode& node : changes.nodes) {
    const NodeId id = node.id;
    nodes_.insert_or_assign(id, std::move(node));
  }
  for (const NodeId id : changes.removed) {
    nodes_.erase(id);
  }
  keyframes_ = std::move(changes.keyframes);
}

}  // namespace hgg
