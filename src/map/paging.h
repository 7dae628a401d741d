#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "map/map.h"

namespace hgg {

/// Gives a page that is out of memory as it is, and leaves it where it is. The error: it cannot be read.
using PageReader = std::function<Result<MapPage>(KeyframeId)>;

/// What a page store gives.
struct TakenPage {
  std::optional<MapPage> page;  // nullopt: not there yet
  bool is_lost = false;         // and it never will be
};

/// Where pages are kept while they are out of memory, and which may leave it. A page is what is anchored to one
/// keyframe: a loop renames tiles and moves keyframes, but a node never changes its anchor, and the leaves of its
/// object frame never change with a loop.
///
/// Reading never loads anything. Who is about to read a part of the map brings it back first: before a frame is
/// aligned, before a loop candidate is cut out and before nodes are merged.
struct PageStore {
  std::function<void(MapPage)> put;
  std::function<TakenPage(KeyframeId)> take;  // the page that was put; after it is given it is not asked for again
  /// Pages without a node this near to the robot may leave, m; none does while it is infinite.
  double keep_radius = std::numeric_limits<double>::infinity();
  /// They leave when the map is larger than this, MB, the farthest first.
  double budget_mb = 0;
  /// Whether pages can be put now: false while the disk cannot take them. Empty: always.
  std::function<bool()> has_room = nullptr;
  /// Whether the store cannot write: only then is detail given up for good. Without it, a store without room fails.
  std::function<bool()> is_failing = nullptr;
  /// Pages that come back at a time, where a frame must not wait for all: the nearest. What comes later is merged with
  /// what was mapped in its place.
  std::size_t most_at_once = std::numeric_limits<std::size_t>::max();
  /// Pages that will be asked for soon. May be empty.
  std::function<void(const std::vector<KeyframeId>&)> prefetch = nullptr;
  /// Memory that the store itself takes, MB. May be empty.
  std::function<double()> megabytes = nullptr;
  /// Without it, all has to be brought back before the map is stored.
  PageReader read = nullptr;
  /// What is wrong with it, a line; empty: nothing. May be empty itself.
  std::function<std::string()> trouble = nullptr;

  bool isOpen() const { return static_cast<bool>(put) && keep_radius < std::numeric_limits<double>::infinity(); }
};

/// Brings back every page that may hold a node within `radius` (m) of `centre`, as far as the store gives it. The delta
/// names their nodes as changed, and those of them that have to be merged with what is there now. Its revision is 0
/// when nothing came back.
MapDelta bringBack(Map& map, const PageStore& store, const Vec3& centre, double radius);

/// Pages out what has no node within the store's keep_radius of `centre`, the farthest first, until map and store are
/// within nine tenths of its budget, but no more than `most` pages; never nodes that still have to be merged
/// (`pending`, ascending ids), nor the last keyframe's, which the next frames go on with.
MapDelta pageOutBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending,
                       std::size_t most = std::numeric_limits<std::size_t>::max());

/// The same for a store that takes nothing: the leaves of the oldest of those pages are made coarser, and given up
/// where they are coarse already. Their nodes stay. `leaf_size`: of the finest leaves, m.
MapDelta dropDetailBeyond(Map& map, const PageStore& store, const Vec3& centre, const std::vector<NodeId>& pending,
                          double leaf_size, std::size_t most);

}  // namespace hgg
