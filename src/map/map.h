#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "map/node.h"

namespace hgg {

struct TimedPose {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
};

/// What a frame takes the place of a thing of the map for: the part of a view for each class, one in all when all of
/// the thing is in it.
struct ClassEvidence {
  NodeId id = 0;
  ClassWeights views;
};

/// What one frame does to the map: nodes as they are after fusion. Made by fuse(), carried out by Map::apply().
struct MapUpdate {
  TimedPose pose;
  std::vector<MapNode> changed;         // existing ids, whole new state
  std::vector<MapNode> created;         // id 0: the map gives them one
  std::vector<NodeId> removed;          // absorbed into another node, or faded
  std::vector<ClassEvidence> evidence;  // of existing things that are otherwise as they were
};

/// Ids a revision touched, for subscribers.
struct MapDelta {
  std::int64_t revision = 0;
  std::vector<NodeId> changed;  // created, changed or witnessed, ascending
  std::vector<NodeId> removed;  // ascending
};

/// The global scene graph. Only apply() mutates it.
class Map {
 public:
  MapDelta apply(MapUpdate update);

  const std::map<NodeId, MapNode>& nodes() const { return nodes_; }
  const MapNode* find(NodeId id) const;
  const MapNode* findTile(ClassId label, const Tile& tile) const;
  /// Ids of nodes whose mean lies within `radius` of `centre`, ascending. Cost depends on the neighbourhood, not on the
  /// map.
  std::vector<NodeId> near(const Vec3& centre, double radius) const;
  /// Poses of the keyframes, oldest first: one every 2 m or 20 degrees of motion, so that a robot at rest costs
  /// nothing.
  const std::vector<TimedPose>& keyframes() const { return keyframes_; }
  std::int64_t revision() const { return revision_; }
  /// Class names of the table the map was built with; empty until set.
  const std::map<ClassId, std::string>& classNames() const { return class_names_; }
  void setClassNames(std::map<ClassId, std::string> names) { class_names_ = std::move(names); }

  /// Edge of the tiles that bound its stuff nodes, m; 0 until set.
  double tileSize() const { return tile_size_; }
  void setTileSize(double tile_size) { tile_size_ = tile_size; }

  /// How many of the nodes are believed in.
  std::size_t believedCount() const;
  std::size_t leafCount() const { return leaf_count_; }
  /// Estimate of the map's own memory in MB (nodes, leaves, index, trajectory).
  double megabytes() const;

  /// The id the next new node gets. An id is given once, also across save and load: what is gone stays gone.
  NodeId nextId() const { return next_id_; }

  /// Rebuilds a map from stored parts (file.cpp, import). Ids must be unique and positive; next_id is raised above
  /// them.
  static Map restore(std::vector<MapNode> nodes, std::vector<TimedPose> keyframes, std::map<ClassId, std::string> names,
                     std::int64_t revision, NodeId next_id = 1);

 private:
  using Cell = Tile;  // coarse grid over node means
  struct CellHash {
    std::size_t operator()(const Cell& c) const;
  };
  struct TileKey {
    ClassId label;
    Tile tile;
    auto operator<=>(const TileKey&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
  };

  void insert(MapNode node);
  void erase(NodeId id);

  std::map<NodeId, MapNode> nodes_;
  std::unordered_map<Cell, std::vector<NodeId>, CellHash> cells_;
  std::map<TileKey, NodeId> tiles_;
  std::vector<TimedPose> keyframes_;
  std::map<ClassId, std::string> class_names_;
  double tile_size_ = 0;
  std::size_t leaf_count_ = 0;
  NodeId next_id_ = 1;
  std::int64_t revision_ = 0;
};

}  // namespace hgg
