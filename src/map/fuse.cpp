#include "map/fuse.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "map/class_evidence.h"
#include "map/patch.h"
#include "map/same_thing.h"
#include "map/stuff_surface.h"

namespace hgg {
namespace {

/// What merging needs of the config.
struct Merging {
  double leaf_size;
  MergeRule rule;
};

Merging mergingOf(const Config& config) {
  return {config.map.leaf_size, config.ablation.symmetric_merge ? mergeSymmetrically : merge};
}

MapNode createNode(const LocalObject& object, const Pose& T_map_body, Micros utime_us, const Merging& merging) {
  MapNode node;
  node.label = object.label;
  node.stuff = object.stuff;
  node.tile = object.tile;
  node.belief = transform(T_map_body, object.belief);
  node.T_map_object = T_map_body * object.T_body_object;
  node.geometry = shareLeaves(fuseLeaves({}, object.leaves, Pose::Identity(), merging.leaf_size, merging.rule));
  if (!node.stuff) {
    addViews(node.classes, {{node.label, 1.0F}});
  }
  node.views = 1;
  node.first_us = node.last_us = utime_us;
  return node;
}

void observe(MapNode& node, const LocalObject& object, const Pose& T_map_body, Micros utime_us,
             const Merging& merging) {
  node.belief = merging.rule(node.belief, transform(T_map_body, object.belief));
  const Pose T_node_object = node.T_map_object.inverse() * T_map_body * object.T_body_object;
  node.geometry =
      shareLeaves(fuseLeaves(leavesOf(node), object.leaves, T_node_object, merging.leaf_size, merging.rule));
  ++node.views;
  node.last_us = std::max(node.last_us, utime_us);
}

/// A thing whose existence falls below this is dropped: fewer than one view in twenty-eight finds it. Chosen by hand,
/// not measured.
constexpr double kFaded = 0.1;

/// An object with a larger share of its points on the surface of a thing is that thing. Chosen by hand, not measured.
constexpr double kSameSurface = 0.5;

/// The likeliest class among those of things. A thing's own class counts even when the class table has changed.
ClassId likeliestThing(ClassBelief belief, const ClassTable& classes, ClassId own) {
  std::erase_if(belief.views, [&](const auto& entry) {
    const ClassInfo* info = classes.find(entry.first);
    return entry.first != own && (info == nullptr || info->kind != ClassKind::kThing);
  });
  return likeliestClass(belief, own);
}

/// Nodes touched by this frame, in a working copy; ids of new nodes are negative until the map gives them real ones.
using Touched = std::map<NodeId, MapNode>;

/// The thing of another class on whose surface the object lies: the object is that thing under a wrong label. Things
/// that this frame has under their own label (`paired`, ascending) are left out. nullptr when there is none, or when
/// the object rather is a piece of a thing of its own class.
const MapNode* findMistaken(const Map& map, const LocalObject& object, const Pose& T_map_body,
                            const std::vector<NodeId>& paired, const Config& config) {
  const MapNode* best = nullptr;
  double most = kSameSurface;
  for (const NodeId id : map.near(T_map_body * object.belief.mean, config.alignment.gate)) {
    const MapNode& node = *map.find(id);
    const double share = node.stuff ? 0 : shareOn(node, object, T_map_body, config.creation.sigma_floor);
    if (share > kSameSurface && node.label == object.label) {
      return nullptr;
    }
    if (share > most && !std::ranges::binary_search(paired, id)) {
      best = &node, most = share;
    }
  }
  return best;
}

Touched touchNodes(const Map& map, const LocalGraph& local, const Pose& T_map_body,
                   const std::vector<ObjectPair>& pairs, const Config& config) {
  const Merging merging = mergingOf(config);
  Touched touched;
  std::vector<NodeId> node_of(local.objects.size(), 0), paired;
  for (const ObjectPair& pair : pairs) {
    node_of[static_cast<std::size_t>(pair.local)] = pair.map;
    paired.push_back(pair.map);
  }
  std::ranges::sort(paired);
  NodeId next_new = -1;
  for (std::size_t i = 0; i < local.objects.size(); ++i) {
    const LocalObject& object = local.objects[i];
    if (node_of[i] == 0 && !object.stuff) {
      const MapNode* mistaken = findMistaken(map, object, T_map_body, paired, config);
      node_of[i] = mistaken != nullptr ? mistaken->id : 0;
    }
    if (node_of[i] == 0) {
      MapNode& node = touched[next_new--] = createNode(object, T_map_body, local.utime_us, merging);
      if (!object.stuff) {
        addViews(node.classes, viewsAsStuff(map, object, T_map_body, config.creation.sigma_floor));
        addViews(node.classes, viewsOfPlane(local, object, config.creation.sigma_floor));
      }
    } else {
      MapNode& node = touched.try_emplace(node_of[i], *map.find(node_of[i])).first->second;
      observe(node, object, T_map_body, local.utime_us, merging);
    }
  }
  return touched;
}

/// Makes nodes of what small clusters have grown into, unless it lies on a thing of another class.
void touchGrownThings(const Map& map, const LocalGraph& local, const Pose& T_map_body,
                      const std::vector<GrownThing>& all, const Config& config, Touched& touched) {
  NodeId next_new = std::min<NodeId>(touched.empty() ? 0 : touched.begin()->first, 0) - 1;
  for (const GrownThing& grown : all) {
    if (findMistaken(map, grown.object, T_map_body, {}, config) != nullptr) {
      continue;
    }
    MapNode& node = touched[next_new--] = createNode(grown.object, T_map_body, local.utime_us, mergingOf(config));
    node.classes = {};
    addViews(node.classes, grown.views);
    addViews(node.classes, viewsAsStuff(map, grown.object, T_map_body, config.creation.sigma_floor));
    addViews(node.classes, viewsOfPlane(local, grown.object, config.creation.sigma_floor));
    node.views = grown.frames;
    node.first_us = grown.first_us;
  }
}

/// The state of a node after this frame so far; nullptr when it has been absorbed.
const MapNode* findCurrent(const Map& map, const Touched& touched, const std::set<NodeId>& removed, NodeId id) {
  const auto held = touched.find(id);
  if (held != touched.end()) {
    return &held->second;
  }
  return removed.contains(id) ? nullptr : map.find(id);
}

/// Another node, its mean within the gate, that the touched thing `id` becomes one with: one object with it, or one of
/// them under another name. 0 when there is none.
NodeId findTwin(const Map& map, const Touched& touched, const std::set<NodeId>& removed, NodeId id,
                const SameThing& rule) {
  const MapNode& self = *findCurrent(map, touched, removed, id);
  const double reach = reachOf(self, rule);
  std::vector<NodeId> others = map.near(self.belief.mean, reach);
  for (auto it = touched.begin(); it != touched.end() && it->first < 0; ++it) {
    others.push_back(it->first);
  }
  for (const NodeId other : others) {
    const MapNode* node = other == id ? nullptr : findCurrent(map, touched, removed, other);
    if (node == nullptr || node->stuff || (node->belief.mean - self.belief.mean).norm() >= reach) {
      continue;
    }
    const bool is_one = node->label == self.label ? areOneObject(self, *node, rule)
                                                  : !rule.loose_pieces && id > 0 && other > 0 &&
                                                        (isOtherName(*node, self, rule.sigma_floor) ||
                                                         isOtherName(self, *node, rule.sigma_floor));
    if (is_one) {
      return other;
    }
  }
  return 0;
}

/// Carries the frame's evidence into the class beliefs: touches things whose likeliest class has become another and
/// gives them its label, removes those that have faded. Returns the evidence of the others.
std::vector<ClassEvidence> believe(const Map& map, const std::vector<ClassEvidence>& evidence,
                                   const ClassTable& classes, Touched& touched, std::set<NodeId>& removed) {
  std::vector<ClassEvidence> rest;
  for (const ClassEvidence& e : evidence) {
    const auto held = touched.find(e.id);
    const MapNode* known = held != touched.end() ? &held->second : map.find(e.id);
    if (known == nullptr) {
      continue;
    }
    const MapNode& before = *known;
    ClassBelief after = before.classes;
    addPlaceView(after, e.view, before.label);
    const ClassId label = likeliestThing(after, classes, before.label);
    if (held == touched.end() && existence(after, label, before.belief.kappa) < kFaded) {
      removed.insert(e.id);
    } else if (held == touched.end() && label == before.label) {
      rest.push_back(e);
    } else {
      MapNode& node = touched.try_emplace(e.id, before).first->second;
      node.classes = std::move(after);
      node.label = label;
    }
  }
  return rest;
}

/// The id that survives a merge: the one already in the map, the older of two.
NodeId survivor(NodeId a, NodeId b) {
  return (a > 0) != (b > 0) ? std::max(a, b) : a > 0 ? std::min(a, b) : std::max(a, b);
}

/// Of two nodes with different names that with fewer views under its own.
NodeId weaker(const Map& map, const Touched& touched, const std::set<NodeId>& removed, NodeId a, NodeId b) {
  const auto own = [&](NodeId id) {
    const MapNode& node = *findCurrent(map, touched, removed, id);
    return weightOf(node.classes.views, node.label);
  };
  return own(a) < own(b) ? a : b;
}

/// Merges every thing of `queue` with the nodes it is one object with, and takes away what is another name for it or
/// for which it is one; ids absorbed out of the map go to `removed`. Returns those that have absorbed another: they are
/// touched.
std::set<NodeId> mergeGhosts(const Map& map, std::vector<NodeId> queue, Touched& touched, const ClassTable& classes,
                             const Config& config, std::set<NodeId>& removed) {
  const Merging merging = mergingOf(config);
  std::set<NodeId> grown;
  for (std::size_t q = 0; q < queue.size(); ++q) {
    const NodeId id = queue[q];
    const MapNode* node = findCurrent(map, touched, removed, id);
    if (node == nullptr) {
      continue;  // absorbed meanwhile
    }
    const SameThing rule = sameThing(classes.find(node->label), config);
    const NodeId twin = findTwin(map, touched, removed, id, rule);
    if (twin == 0) {
      continue;
    }
    if (findCurrent(map, touched, removed, twin)->label != node->label) {
      const NodeId drop = weaker(map, touched, removed, id, twin);  // its surface may go beyond that of the other
      touched.erase(drop);
      removed.insert(drop);
      queue.push_back(id);
      continue;
    }
    const NodeId keep = survivor(id, twin), drop = keep == id ? twin : id;
    MapNode absorbed = *findCurrent(map, touched, removed, drop);
    if (drop < 0 && touched.contains(keep)) {
      absorbed.classes = {};  // a piece: the frame's view of the whole is counted already
    }
    MapNode& whole = touched.try_emplace(keep, *findCurrent(map, touched, removed, keep)).first->second;
    absorb(whole, absorbed, merging.leaf_size, merging.rule);
    touched.erase(drop);
    if (drop > 0) {
      removed.insert(drop);
    }
    queue.push_back(keep);  // it grew: look again
    grown.insert(keep);
  }
  return grown;
}

/// Merges the active nodes of a tile into the oldest of them.
void mergeTile(const Map& map, const MapNode& node, const Merging& merging, Touched& touched, std::set<NodeId>& removed,
               std::set<NodeId>& grown) {
  const std::vector<NodeId> ids = map.activeOfTile(node.label, node.tile);
  for (std::size_t k = 1; k < ids.size(); ++k) {
    if (removed.insert(ids[k]).second) {
      absorb(touched.try_emplace(ids[0], *map.find(ids[0])).first->second, *map.find(ids[k]), merging.leaf_size,
             merging.rule);
      grown.insert(ids[0]);
    }
  }
}

}  // namespace

Belief mergeSymmetrically(const Belief& a, const Belief& b) {
  const Vec3 d = a.mean - b.mean;
  return {0.5 * (a.mean + b.mean), 0.5 * (a.cov + b.cov) + 0.25 * d * d.transpose(), a.kappa + b.kappa};
}

void absorb(MapNode& keep, const MapNode& other, double leaf_size, MergeRule rule) {
  keep.belief = rule(keep.belief, other.belief);
  addViews(keep.classes, other.classes.views);
  keep.classes.seen_through = std::min(keep.classes.seen_through, other.classes.seen_through);
  keep.classes.passed += other.classes.passed;
  std::vector<Belief> leaves;
  leaves.reserve(leavesOf(other).size());
  for (const Leaf& leaf : leavesOf(other)) {
    leaves.push_back(unpackLeaf(leaf));
  }
  const Pose T_keep_other = keep.T_map_object.inverse() * other.T_map_object;
  keep.geometry = shareLeaves(fuseLeaves(leavesOf(keep), leaves, T_keep_other, leaf_size, rule));
  const bool is_later = other.first_us > keep.last_us || keep.first_us > other.last_us;
  keep.views = is_later ? keep.views + other.views : std::max(keep.views, other.views);  // pieces share their views
  keep.first_us = std::min(keep.first_us, other.first_us);
  keep.last_us = std::max(keep.last_us, other.last_us);
}

MapUpdate fuse(const Map& map, const LocalGraph& local, const Pose& T_map_body, const std::vector<ObjectPair>& pairs,
               const std::vector<ClassEvidence>& evidence, const ClassTable& classes, const Config& config,
               SmallThings small) {
  MapUpdate update;
  Touched touched = touchNodes(map, local, T_map_body, pairs, config);
  touchGrownThings(map, local, T_map_body, small.grown, config, touched);
  update.tentative = std::move(small.tentative);
  std::set<NodeId> removed;
  update.evidence = believe(map, evidence, classes, touched, removed);
  std::vector<NodeId> things;
  for (const auto& [id, node] : touched) {
    if (!node.stuff) {
      things.push_back(id);
    }
  }
  mergeGhosts(map, std::move(things), touched, classes, config, removed);
  // What a merge has touched or taken away goes on without this one view.
  std::erase_if(update.evidence,
                [&](const ClassEvidence& e) { return touched.contains(e.id) || removed.contains(e.id); });
  update.removed.assign(removed.begin(), removed.end());
  for (auto& [id, node] : touched) {
    node.id = std::max<NodeId>(id, 0);
    (id > 0 ? update.changed : update.created).push_back(std::move(node));
  }
  // New ids follow the order in which the frame listed the objects; `touched` holds them newest first.
  std::reverse(update.created.begin(), update.created.end());
  return update;
}

MapUpdate mergeDuplicates(const Map& map, const std::vector<NodeId>& pending, const ClassTable& classes,
                          const Config& config) {
  MapUpdate update;
  update.is_sequel = true;
  Touched touched;
  std::vector<NodeId> things;
  std::set<NodeId> removed, grown;
  for (const NodeId id : pending) {
    const MapNode* node = map.find(id);
    if (node == nullptr || !map.isActive(*node)) {
      continue;
    }
    if (node->stuff) {
      mergeTile(map, *node, mergingOf(config), touched, removed, grown);
    } else {
      things.push_back(id);
    }
  }
  grown.merge(mergeGhosts(map, std::move(things), touched, classes, config, removed));
  for (const NodeId id : grown) {
    if (const auto node = touched.find(id); node != touched.end()) {
      update.changed.push_back(std::move(node->second));
    }
  }
  update.removed.assign(removed.begin(), removed.end());
  return update;
}

}  // namespace hgg
