#pragma once

#include <compare>
#include <cstdint>

#include "core/belief.h"
#include "core/class_belief.h"
#include "map/geometry.h"

namespace hgg {

using NodeId = std::int64_t;

/// Index of a cubic cell of the map frame that bounds one node of a stuff class; cell (0,0,0) is centred on the origin.
struct Tile {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const Tile&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
};

/// The tile of a map-frame position.
Tile tileOf(const Vec3& p_map, double tile_size);

/// Index into the keyframes of a map, in the order of their making; -1 for none.
using KeyframeId = std::int32_t;

/// An object node of the map. The object frame T_map_object (origin = mean, axes = eigenvectors of the extent, both at
/// creation) is a gauge: merges update the belief and leave the frame alone, so no leaf moves because two eigenvalues
/// crossed.
struct MapNode {
  NodeId id = 0;
  ClassId label = 0;
  bool stuff = false;
  Tile tile;      // stuff only
  Belief belief;  // map frame
  Pose T_map_object = Pose::Identity();
  GeometryBlock geometry = noLeaves();  // read through leavesOf()
  ClassBelief classes;     // things only: what views took its place for; `label` is the likeliest thing of it
  std::int32_t views = 0;  // objects of frames merged into this node
  KeyframeId anchor = -1;  // the keyframe it was made at; the node moves rigidly with it
  Micros first_us = 0, last_us = 0;
};

/// The node's leaves, which must be in memory: reading those of a node that was paged out is a bug and aborts.
const Leaves& leavesOf(const MapNode& node);

/// Probability that there is something of the node's class at its place; 1 for stuff, which is taken as it is.
double existenceOf(const MapNode& node);

/// True when there more likely is something than not; what is not believed in is kept, to learn about it, and not
/// published.
bool isConfirmed(const MapNode& node);

/// How well the node's mean is known, m^2: cov / n_eff + sigma^2 I. Points of one view are not independent, so that
/// kappa is not what counts: a view is worth 1 / 0.7^2 points and none of its noise less than 5 cm, all views together
/// no more than 1 / 0.06^2 points and 2 cm.
Mat3 positionCovariance(const MapNode& node);

/// Edge of the relative neighbourhood graph with its weight (eq. rel_weights); a < b.
struct Edge {
  NodeId a = 0, b = 0;
  float weight = 0;
};

}  // namespace hgg
