#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "map/map.h"

namespace hgg {

/// Where pages are kept while they are out of memory, and which may leave it. A page is what is anchored to one
/// keyframe: a loop renames tiles and moves keyframes, but a node never changes its anchor, and the leaves of its
/// object frame never change with a loop.
///
/// Reading never loads anything. Who is about to read a part of the map brings it back first: before a frame is
/// aligned, before a loop candidate is cut out, before nodes are merged and before the map is stored.
struct PageStore {
  std::function<void(MapPage)> put;
  std::function<MapPage(KeyframeId)> take;  // gives the page that was put; it is asked for once each
  /// Pages without a node this near to the robot may leave, m; none does while it is infinite.
  double keep_radius = std::numeric_limits<double>::infinity();
};

/// Brings back every page that may hold a node within `radius` (m) of `centre`. The delta names their nodes as changed,
/// and those of them that have to be merged with what is there now. Its revision is 0 when nothing was paged out.
MapDelta bringBack(Map& map, const PageStore& store, const Vec3& centre, double radius);

/// Pages out what has no node within the store's keep_radius of `centre`; never nodes that still have to be merged
/// (`pending`, ascending ids), nor the last keyframe's, which the next frames go on with.
MapDelta pageOutBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending);

}  // namespace hgg
