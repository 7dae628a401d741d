#include "map/second_nodes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "map/fuse.h"
#include "map/patch.h"
#include "map/position.h"
#include "map/same_thing.h"

namespace hgg {
namespace {

/// True when what the two may have drifted apart is less than clustering bridges, or frames are matched with both.
bool isDriftSmall(const Map& map, const MapNode& a, const MapNode& b, double cluster_radius) {
  if (map.isActive(a) && map.isActive(b)) {
    return true;
  }
  const double variance = relativeCovariance(map, a, b).trace() / 3;
  return std::sqrt(variance) < kFragmentDistance * cluster_radius;
}

}  // namespace

MapUpdate mergeSecondNodes(const Map& map, const ClassTable& classes, const Config& config) {
  std::map<NodeId, MapNode> grown;
  std::set<NodeId> removed;
  const auto current = [&](NodeId id) -> const MapNode& {
    const auto held = grown.find(id);
    return held != grown.end() ? held->second : *map.find(id);
  };
  const auto twinOf = [&](NodeId id) -> NodeId {
    const MapNode& self = current(id);
    const SameThing rule = sameThing(classes.find(self.label), config);
    for (const NodeId other : map.nearAnywhere(self.belief.mean, reachOf(self, rule))) {
      if (other == id || removed.contains(other)) {
        continue;
      }
      const MapNode& node = current(other);
      if (!node.stuff && node.label == self.label && areOneObject(self, node, rule) &&
          isDriftSmall(map, self, node, rule.cluster_radius)) {
        return other;
      }
    }
    return 0;
  };
  const MergeRule rule = config.ablation.symmetric_merge ? mergeSymmetrically : merge;
  for (const auto& [id, node] : map.nodes()) {
    if (node.stuff || removed.contains(id)) {
      continue;
    }
    NodeId keep = id;
    for (NodeId twin = twinOf(keep); twin != 0; twin = twinOf(keep)) {
      const NodeId drop = std::max(keep, twin);
      const MapNode& absorbed = current(drop);  // stays where it is until it is erased below
      keep = std::min(keep, twin);
      absorb(grown.try_emplace(keep, current(keep)).first->second, absorbed, config.map.leaf_size, rule);
      grown.erase(drop);
      removed.insert(drop);
    }
  }
  MapUpdate update;
  update.is_sequel = true;
  for (auto& [id, node] : grown) {
    update.changed.push_back(std::move(node));
  }
  update.removed.assign(removed.begin(), removed.end());
  return update;
}

}  // namespace hgg
