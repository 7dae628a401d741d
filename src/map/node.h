#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>

#include "core/belief.h"
#include "core/class_belief.h"
#include "map/geometry.h"

namespace hgg {

using NodeId = std::int64_t;

/// Index of a cubic tile of the map frame, which bounds one node of a stuff class; tile (0,0,0) is centred on the
/// origin.
struct Tile {
  std::int32_t x = 0, y = 0, z = 0;
  auto operator<=>(const Tile&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
};

/// The tile that a map-frame position lies in; `tile_size` is its edge (m).
Tile tileOf(const Vec3& p_map, double tile_size);

/// Index into the keyframes of a map, in the order of their making; -1 for none.
using KeyframeId = std::int32_t;

/// What is known of a thing beside its shape, where something told it (`hggmap import`).
struct Looks {
  std::optional<std::array<std::uint8_t, 3>> rgb;  // mean colour of its surface, sRGB
  std::optional<Vec3> front_object;                // unit vector to the side it is used from, object frame
};

/// An object node of the map. The object frame T_map_object has its origin at the mean and its axes along the
/// eigenvectors of the extent, both as they were when the node was created. Merges update the belief and leave the
/// frame alone, so that the leaves do not turn when two eigenvalues become equal and swap.
struct MapNode {
  NodeId id = 0;
  ClassId label = 0;
  bool stuff = false;
  Tile tile;      // stuff only
  Belief belief;  // map frame
  Pose T_map_object = Pose::Identity();
  GeometryBlock geometry = noLeaves();  // read through leavesOf()
  ClassBelief classes;     // things only: how views labelled its place; `label` is the likeliest class of things in it
  std::int32_t views = 0;  // objects of frames merged into this node
  KeyframeId anchor = -1;  // the keyframe it was made from: the node moves rigidly with its anchor keyframe
  Looks looks;
  Micros first_us = 0, last_us = 0;
};

/// The part of the map around a node is moved rigidly (T_map_map). Stuff is then of the tile that it lies in, unless
/// there are none (`tile_size` 0).
void moveBy(const Pose& move, double tile_size, MapNode& node);

/// The node's leaves, which must be in memory: reading those of a node that was paged out is a bug and aborts.
const Leaves& leavesOf(const MapNode& node);

/// Probability that there is an object of the node's class at its place; 1 for stuff, which is not doubted.
double existenceOf(const MapNode& node);

/// True when the object more likely exists than not. Other nodes are kept as candidates and not published.
bool isConfirmed(const MapNode& node);

/// How well the node's mean is known, m^2: the model of core/position_uncertainty.h within one drive. A view is worth
/// two points at most however many it has, and all views together no more than 280 points and 2 cm.
Mat3 positionCovariance(const MapNode& node);

/// Edge of the relative neighbourhood graph over the nodes, with its weight (eq. rel_weights); a < b.
struct Edge {
  NodeId a = 0, b = 0;
  float weight = 0;
};

}  // namespace hgg
