#pragma once

#include <limits>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "map/keyframes.h"
#include "map/node.h"

namespace hgg {

/// How a frame labels the place of a thing: a share of a view for each class. The shares add up to one (or to the
/// weight of the frame) when the frame sees all of the thing.
struct ClassEvidence {
  NodeId id = 0;
  ClassWeights views;
};

/// What one frame changes in the map: nodes as they are after fusion. fuse() computes it, Map::apply() carries it out.
struct MapUpdate {
  TimedPose pose;
  std::vector<BetweenConstraint> constraints;  // added if the pose becomes a keyframe, as b (their own b is not used)
  std::vector<MapNode> changed;                // existing nodes in their new state
  std::vector<MapNode> created;                // with id 0: the map gives them one
  std::vector<NodeId> removed;                 // absorbed into another node, or faded
  std::vector<ClassEvidence> evidence;         // for existing things that do not change otherwise
  bool is_sequel = false;                      // belongs to the revision of the frame before it
};

/// What correction changes in the map: new poses of keyframes, and loops that were closed.
struct MapCorrection {
  std::vector<std::pair<KeyframeId, Pose>> moved;  // T_map_body; at most once each
  std::vector<BetweenConstraint> loops;
  bool is_measured = false;  // constraints among the moved keyframes take over the new poses, which know more than they
};

/// The ids of the nodes that a revision touched, for subscribers. All ascending.
struct MapDelta {
  std::int64_t revision = 0;
  std::vector<NodeId> changed;  // created, changed, or with new class evidence
  std::vector<NodeId> moved;    // rigidly with their anchor keyframes, and not changed otherwise
  std::vector<NodeId> removed;
  std::vector<NodeId> reactivated;  // not active before, active now: the same object may have a second node
  std::vector<NodeId> colliding;    // stuff that was moved into a tile that has another node
};

/// The global scene graph. Only apply() mutates it.
///
/// A node is active when the drift between its anchor keyframe and the last keyframe is below the drift reach
/// (KeyframeGraph::driftFrom). Frames are only matched with active nodes: the other parts of the map may have drifted
/// so far that a frame would be matched with the wrong object. They become active again when a loop is closed.
class Map {
 public:
  MapDelta apply(MapUpdate update);
  /// Moves keyframes, and each node rigidly with its anchor keyframe. Stuff nodes are assigned the tiles that they lie
  /// in afterwards. Belongs to the revision of the frame before it.
  MapDelta apply(const MapCorrection& correction);

  const std::map<NodeId, MapNode>& nodes() const { return nodes_; }
  const MapNode* find(NodeId id) const;
  /// The active node of a tile, the oldest where there are more; nullptr when there is none.
  const MapNode* findTile(ClassId label, const Tile& tile) const;
  /// All active nodes of a tile, ascending. There can be several after a loop has moved one onto another.
  std::vector<NodeId> activeOfTile(ClassId label, const Tile& tile) const;
  /// Ids of active nodes whose mean lies within `radius` of `centre`, ascending. Cost depends on the neighbourhood, not
  /// on the map.
  std::vector<NodeId> near(const Vec3& centre, double radius) const;
  /// The same for all nodes, active or not.
  std::vector<NodeId> nearAnywhere(const Vec3& centre, double radius) const;
  bool isActive(const MapNode& node) const { return isActive(node.anchor); }
  /// Whether the nodes anchored to a keyframe are active; true for none (-1).
  bool isActive(KeyframeId id) const;
  const KeyframeGraph& keyframes() const { return keyframes_; }
  std::int64_t revision() const { return revision_; }
  /// Class names of the table the map was built with; empty until set.
  const std::map<ClassId, std::string>& classNames() const { return class_names_; }
  void setClassNames(std::map<ClassId, std::string> names) { class_names_ = std::move(names); }

  /// Edge of the tiles that bound stuff nodes, m; 0 until set.
  double tileSize() const { return tile_size_; }
  void setTileSize(double tile_size) { tile_size_ = tile_size; }
  /// Sets the drift (m) from which on a node is not active; infinite until set. Takes effect at the next keyframe or
  /// constraint.
  void setDriftReach(double reach) { drift_reach_ = reach; }
  /// Makes the nodes active that are within reach of keyframe `id`, at which the robot goes on in a stored map.
  void startAt(KeyframeId id);

  /// Number of nodes that are confirmed (isConfirmed).
  std::size_t confirmedCount() const;
  std::size_t leafCount() const { return leaf_count_; }
  /// Estimate of the map's own memory in MB (nodes, leaves, index, trajectory).
  double megabytes() const;

  /// The id that the next new node gets. An id is given once only, also across save and load, so that the id of a
  /// removed node never comes to mean another.
  NodeId nextId() const { return next_id_; }

  /// Rebuilds a map from stored parts (file.cpp, import). Ids must be unique and positive; next_id is raised above
  /// them.
  static Map restore(std::vector<MapNode> nodes, KeyframeGraph keyframes, std::map<ClassId, std::string> names,
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
  void index(const MapNode& node);
  void unindex(const MapNode& node);
  /// Moves what is anchored to the keyframes of `moves`.
  void moveNodes(const KeyframeMoves& moves, MapDelta& delta);
  /// True when it lies in another tile now.
  bool moveNode(MapNode& node, const Pose& move);
  void findActive(KeyframeId from, MapDelta& delta);

  std::map<NodeId, MapNode> nodes_;
  std::unordered_map<Cell, std::vector<NodeId>, CellHash> cells_;
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
