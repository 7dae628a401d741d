#pragma once

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "map/file.h"
#include "map/map.h"
#include "random_geometry.h"

namespace hgg {

/// Gives a node one more leaf.
inline void addLeaf(MapNode& node, const Leaf& leaf) {
  Leaves leaves = leavesOf(node);
  leaves.push_back(leaf);
  node.geometry = shareLeaves(std::move(leaves));
}

/// A map node of a round extent that is confirmed.
inline MapNode nodeAt(ClassId label, const Vec3& mean, double deviation = 0.5, double kappa = 100) {
  MapNode node;
  node.label = label;
  node.belief = {mean, deviation * deviation * Mat3::Identity(), kappa};
  node.T_map_object.translation() = mean;
  node.views = 1;
  addViews(node.classes, {{label, 1000.0F}});
  return node;
}

inline MapNode tileNode(ClassId label, const Tile& tile, const Vec3& mean, double kappa = 100) {
  MapNode node = nodeAt(label, mean, 2, kappa);
  node.classes = {};
  node.stuff = true;
  node.tile = tile;
  return node;
}

/// `pose` as a new keyframe of the map where that needs one, as the corrector decides it.
inline std::optional<NewKeyframe> keyframeIfNeeded(const Map& map, const TimedPose& pose,
                                                   std::vector<BetweenConstraint> constraints = {}) {
  return map.keyframes().needsOne(pose.T_map_body) ? std::optional(NewKeyframe{pose, std::move(constraints)})
                                                   : std::nullopt;
}

/// A map of these nodes, anchored to one keyframe at the origin; ids are 1, 2, ... in their order.
inline Map mapOf(std::vector<MapNode> nodes) {
  Map map;
  MapUpdate update;
  update.keyframe = NewKeyframe{};
  update.created = std::move(nodes);
  map.apply(std::move(update));
  return map;
}

inline Leaf randomLeaf(std::mt19937& random) { return packLeaf(randomBelief(random, 3)); }

inline MapNode randomNode(std::mt19937& random, double extent) {
  MapNode node;
  node.label = static_cast<ClassId>(below(random, 20));
  node.belief = randomBelief(random, extent);
  node.T_map_object = randomPose(random, 1);
  node.T_map_object.translation() = node.belief.mean;
  node.views = 1 + static_cast<std::int32_t>(below(random, 100));
  for (ClassId other = 0; other < 40; other = static_cast<ClassId>(other + 1 + below(random, 20))) {
    addViews(node.classes, {{other, static_cast<float>(below(random, 50))}});
  }
  node.first_us = static_cast<Micros>(random());
  node.last_us = node.first_us + static_cast<Micros>(random());
  for (std::uint32_t leaves = below(random, 6); leaves > 0; --leaves) {
    addLeaf(node, randomLeaf(random));
  }
  return node;
}

}  // namespace hgg
