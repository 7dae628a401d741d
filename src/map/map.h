#pragma once

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/point_index.h"
#include "map/keyframes.h"
#include "map/node.h"
#include "map/object_graph.h"

namespace hgg {

/// What a frame takes the place of a thing of the map for: the part of a view for each class, one in all when all of
/// the thing is in it.
struct ClassEvidence {
  NodeId id = 0;
  ClassWeights views;
};

/// What one frame does to the map: nodes as they are after fusion. Made by fuse(), carried out by Map::apply().
struct MapUpdate {
  TimedPose pose;
  std::vector<BetweenConstraint> constraints;  // of the pose to keyframes, should it become one; their b is not used
  std::vector<MapNode> changed;                // existing ids, whole new state
  std::vector<MapNode> created;                // id 0: the map gives them one
  std::vector<NodeId> removed;                 // absorbed into another node, or faded
  std::vector<ClassEvidence> evidence;         // of existing things that are otherwise as they were
  bool is_sequel = false;                      // to the frame before it, whose revision it belongs to
};

/// What correction does to the map: keyframes and where they are to be, and loops that were closed.
struct MapCorrection {
  std::vector<std::pair<KeyframeId, Pose>> moved;  // T_map_body; at most once each
  std::vector<BetweenConstraint> loops;
  bool is_measured = false;  // constraints among the moved follow: more was looked at than when they were made
};

/// Ids a revision touched, for subscribers.
struct MapDelta {
  std::int64_t revision = 0;
  std::vector<NodeId> changed;      // created, changed or witnessed, ascending
  std::vector<NodeId> moved;        // rigidly with their anchors and otherwise as they were, ascending
  std::vector<NodeId> removed;      // ascending
  std::vector<NodeId> reactivated;  // active from now on, ascending: may be there twice
  std::vector<NodeId> colliding;    // moved into a tile that has another node, ascending
  std::vector<NodeId> rewired;      // otherwise as they were, with other edges in the object graph, ascending
};

/// The global scene graph. Only apply() mutates it.
///
/// A node is active when its anchor lies within the reach of the last keyframe (KeyframeGraph::driftFrom). What is not
/// may have drifted so far that a frame would be laid over the wrong part of it: frames meet active nodes only, until a
/// loop is closed.
class Map {
 public:
  MapDelta apply(MapUpdate update);
  /// Moves each node rigidly with its anchor. Tiles are named anew by where they have come to lie. Belongs to the
  /// revision of the frame before it.
  MapDelta apply(const MapCorrection& correction);

  const std::map<NodeId, MapNode>& nodes() const { return nodes_; }
  const MapNode* find(NodeId id) const;
  /// The active node of a tile, the oldest where there are more; nullptr when there is none.
  const MapNode* findTile(ClassId label, const Tile& tile) const;
  /// All of them, ascending: what has moved may have come to lie on another.
  std::vector<NodeId> activeOfTile(ClassId label, const Tile& tile) const;
  /// Ids of active nodes whose mean lies within `radius` of `centre`, ascending. Cost depends on the neighbourhood, not
  /// on the map.
  std::vector<NodeId> near(const Vec3& centre, double radius) const;
  /// The same of all nodes.
  std::vector<NodeId> nearAnywhere(const Vec3& centre, double radius) const;
  bool isActive(const MapNode& node) const { return isActive(node.anchor); }
  /// Whether what hangs on a keyframe is active; true for none (-1).
  bool isActive(KeyframeId id) const;
  const KeyframeGraph& keyframes() const { return keyframes_; }
  std::int64_t revision() const { return revision_; }
  /// Class names of the table the map was built with; empty until set.
  const std::map<ClassId, std::string>& classNames() const { return class_names_; }
  void setClassNames(std::map<ClassId, std::string> names) { class_names_ = std::move(names); }

  /// Edge of the tiles that bound its stuff nodes, m; 0 until set.
  double tileSize() const { return tile_size_; }
  void setTileSize(double tile_size) { tile_size_ = tile_size; }
  /// Drift (m) from which on a node is not active; infinite until set. Takes effect at the next keyframe or tie.
  void setDriftReach(double reach) { drift_reach_ = reach; }
  /// Makes active what lies within reach of a keyframe: where the robot is as it goes on from a stored map.
  void startAt(KeyframeId id);

  /// The relative neighbourhood graph of the nodes believed in. Follows every change, those of a closed loop over the
  /// frames after it. Empty until the edge model is set.
  const ObjectGraph& graph() const { return graph_; }
  /// Builds the graph of the nodes that are there, and keeps it from now on.
  void setEdgeModel(const EdgeModel& model);
  /// Makes the graph exact where a loop has left it to later frames: before a map is stored.
  void settleGraph() { graph_.settle(); }

  /// How many of the nodes are believed in.
  std::size_t confirmedCount() const;
  std::size_t leafCount() const { return leaf_count_; }
  /// Estimate of the map's own memory in MB (nodes, leaves, index, trajectory).
  double megabytes() const;

  /// The id the next new node gets. An id is given once, also across save and load: what is gone stays gone.
  NodeId nextId() const { return next_id_; }

  /// Rebuilds a map from stored parts (file.cpp, import). Ids must be unique and positive; next_id is raised above
  /// them.
  static Map restore(std::vector<MapNode> nodes, KeyframeGraph keyframes, std::map<ClassId, std::string> names,
                     std::int64_t revision, NodeId next_id = 1);

 private:
  struct TileKey {
    ClassId label;
    Tile tile;
    auto operator<=>(const TileKey&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
  };

  void insert(MapNode node);
  void erase(NodeId id);
  void indexTile(const MapNode& node);
  void unindexTile(const MapNode& node);
  /// Tells the object graph how a node is now.
  void enterGraph(const MapNode& node);
  /// Moves what is anchored to the keyframes of `moves`.
  void moveNodes(const KeyframeMoves& moves, MapDelta& delta);
  /// True when it lies in another tile now.
  bool moveNode(MapNode& node, const Pose& move);
  void findActive(KeyframeId from, MapDelta& delta);

  std::map<NodeId, MapNode> nodes_;
  PointIndex means_;
  ObjectGraph graph_;
  std::map<TileKey, std::vector<NodeId>> tiles_;  // more than one where some are not active
  KeyframeGraph keyframes_;
  std::vector<bool> active_;                   // keyframes
  std::vector<std::vector<NodeId>> anchored_;  // to each keyframe
  double drift_reach_ = std::numeric_limits<double>::infinity();
  std::map<ClassId, std::string> class_names_;
  double tile_size_ = 0;
  std::size_t leaf_count_ = 0;
  NodeId next_id_ = 1;
  std::int64_t revision_ = 0;
};

}  // namespace hgg
