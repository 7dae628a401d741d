#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/point_index.h"
#include "map/drift.h"
#include "map/keyframes.h"
#include "map/map_changes.h"
#include "map/node.h"
#include "map/object_graph.h"
#include "map/tentative_things.h"

namespace hgg {

/// What a frame sees at the place of a thing: a share of a view for each class, and for free space. The shares add up
/// to one (or to the weight of the frame) when the frame sees all of the thing.
struct ClassEvidence {
  NodeId id = 0;
  PlaceView view;
};

/// A frame that becomes a keyframe.
struct NewKeyframe {
  TimedPose pose;
  std::vector<BetweenConstraint> constraints;  // from keyframes of the map to it; their b is not used
};

/// What one frame does to the map: nodes as they are after fusion. Made by fuse(), carried out by Map::apply().
struct MapUpdate {
  std::optional<NewKeyframe> keyframe;       // added first, so that created nodes are anchored to it
  KeyframeId taken_up = -1;                  // a keyframe that the robot is at again, likewise; -1: none
  std::vector<MapNode> changed;              // existing ids, whole new state
  std::vector<MapNode> created;              // id 0: the map gives them one
  std::vector<NodeId> removed;               // absorbed into another node, or faded
  std::vector<ClassEvidence> evidence;       // of existing things that are otherwise as they were
  bool is_sequel = false;                    // belongs to the revision of the frame before it
  std::optional<TentativeThings> tentative;  // as they are from now on
};

/// What correction does to the map: the new poses of keyframes, and the loops that were closed.
struct MapCorrection {
  std::vector<std::pair<KeyframeId, Pose>> moved;  // T_map_body; at most once each
  std::vector<BetweenConstraint> loops;
  bool is_measured = false;  // by more than the constraints among the moved say: these are set to the new poses
  std::optional<Loosening> loosened = std::nullopt;  // what the loops have overruled
};

/// The ids of the nodes that a revision touched, for subscribers. All ascending.
struct MapDelta {
  std::int64_t revision = 0;
  std::vector<NodeId> changed;  // created, changed, or with new class evidence
  std::vector<NodeId> moved;    // rigidly with their anchor keyframes, and not changed otherwise
  std::vector<NodeId> removed;
  std::vector<NodeId> reactivated;  // not active before, active now: the same object may have a second node
  std::vector<NodeId> colliding;    // stuff that was moved into a tile that has another node
  std::vector<NodeId> rewired;      // not changed otherwise, with other edges in the object graph
  std::vector<NodeId> left;         // not in memory any more, and otherwise as they were
};

/// What was done first and then, as one change. Each node is named once: as removed before as changed, and as changed
/// before as moved. What has to be merged is not carried over: it is noted when it comes up.
MapDelta joined(MapDelta first, const MapDelta& second);

/// The global scene graph. Only apply() changes what it says; paging (map/paging.h) changes what of it is in memory.
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
  /// The leaves of a node, in its object frame. The block stays what it is while the map goes on, so it may be kept or
  /// handed to another thread. The node must be there and in memory: anything else is a bug and aborts.
  GeometryBlock geometry(NodeId id) const;
  /// The active node of a tile, the oldest where there are more; nullptr when there is none.
  const MapNode* findTile(ClassId label, const Tile& tile) const;
  /// All active nodes of a tile, ascending. There can be several after a loop has moved one onto another.
  std::vector<NodeId> activeOfTile(ClassId label, const Tile& tile) const;
  /// Ids of active nodes whose mean lies within `radius` of `centre`, ascending. Cost depends on the neighbourhood, not
  /// on the map.
  std::vector<NodeId> near(const Vec3& centre, double radius) const;
  /// The same for all nodes, active or not.
  std::vector<NodeId> nearAnywhere(const Vec3& centre, double radius) const;
  /// The active keyframe that a pose is at, the nearest of them; -1 when there is none.
  KeyframeId keyframeAt(const Pose& T_map_body) const;
  /// Keyframes within `radius` (m) of a place, ascending.
  std::vector<KeyframeId> keyframesNear(const Vec3& centre, double radius) const;
  bool isActive(const MapNode& node) const { return isActive(node.anchor); }
  /// Whether the nodes anchored to a keyframe are active; true for none (-1).
  bool isActive(KeyframeId id) const;
  /// What may become nodes: evidence of small things that is not enough yet.
  const TentativeThings& tentative() const { return tentative_; }
  const KeyframeGraph& keyframes() const { return keyframes_; }
  /// How far a keyframe may have drifted: the covariance of its pose in the map, in the tangent of core/se3.h. Zero for
  /// none (-1).
  Mat6 poseCovariance(KeyframeId id) const { return pose_covariances_.of(id); }
  std::int64_t revision() const { return revision_; }
  /// Class names of the table the map was built with; empty until set.
  const std::map<ClassId, std::string>& classNames() const { return class_names_; }
  void setClassNames(std::map<ClassId, std::string> names) { class_names_ = std::move(names); }

  /// Edge of the tiles that bound stuff nodes, m; 0 until set.
  double tileSize() const { return tile_size_; }
  void setTileSize(double tile_size) { tile_size_ = tile_size; }
  /// By how much odometry's stamps lagged behind the clouds' when it was last seen, us: a session that goes on in the
  /// map starts with it.
  Micros odometryDelay_us() const { return odometry_delay_us_; }
  void setOdometryDelay(Micros delay_us) { odometry_delay_us_ = delay_us; }
  /// Sets the drift (m) from which on a node is not active; infinite until set. Takes effect at the next keyframe or
  /// constraint.
  void setDriftReach(double reach) { drift_reach_ = reach; }
  /// Makes the nodes active that are within the drift reach of keyframe `id`, at which the robot goes on in a stored
  /// map.
  void startAt(KeyframeId id);

  /// The relative neighbourhood graph of the confirmed nodes. Follows every change, those of a closed loop over the
  /// frames after it. Empty until the edge model is set.
  const ObjectGraph& graph() const { return graph_; }
  /// Builds the graph of the nodes that are there, and keeps it from now on.
  void setEdgeModel(const EdgeModel& model);
  /// Makes the graph exact where a loop has left it to later frames: before a map is stored.
  void settleGraph() { graph_.settle(); }

  /// Ids of the nodes in memory that are anchored to a keyframe, in no particular order.
  const std::vector<NodeId>& anchoredTo(KeyframeId id) const { return anchored_.at(static_cast<std::size_t>(id)); }
  /// Takes what is anchored to these keyframes out of memory. Edges to it leave the object graph with it; the delta
  /// names the nodes whose edges that has changed.
  std::vector<MapPage> pageOut(const std::vector<KeyframeId>& ids, MapDelta& delta);
  /// Puts pages back: their nodes move as far as their keyframes were moved meanwhile. The delta names the nodes as
  /// changed, and what has to be merged because it lies on something else or was not active in between.
  MapDelta pageIn(std::vector<MapPage> pages);
  /// Forgets a page that cannot be read back: its nodes are lost.
  void giveUp(KeyframeId id);
  /// What was looked for and could not be brought back in time: it is taken for not active in between, so that what has
  /// been mapped in its place is merged with it.
  void missed(KeyframeId id);
  /// False while some of it is paged out.
  bool isWhole() const { return paged_out_.empty(); }
  /// Keyframes whose nodes are paged out, ascending.
  std::vector<KeyframeId> pagedOut() const;
  /// Keyframes that are paged out and may have a node within `radius` (m) of `centre`, ascending.
  std::vector<KeyframeId> pagedOutNear(const Vec3& centre, double radius) const;
  /// Keyframes that are paged out and may have something to be merged: they were moved by a loop since, or have become
  /// active. Ascending.
  std::vector<KeyframeId> pagedOutStale() const;

  /// From now on what changes is noted, for takeChanges().
  void trackChanges();
  /// What has changed since the last call, or all there is in memory. What is paged out is not among it.
  MapChanges takeChanges(bool all);

  /// Number of nodes that are confirmed (isConfirmed).
  std::size_t confirmedCount() const;
  std::size_t leafCount() const { return leaf_count_; }
  /// Estimate of the map's own memory in MB (nodes, leaves, index, trajectory).
  double megabytes() const;
  /// Of so many nodes and leaves, MB.
  static double megabytesOf(std::size_t nodes, std::size_t leaves);

  /// The id that the next new node gets. An id is given once only, also across save and load, so that the id of a
  /// removed node never comes to mean another.
  NodeId nextId() const { return next_id_; }
  /// Gives one away to something that is told of beside the nodes (map/movers.h).
  NodeId takeId() { return next_id_++; }

  /// Rebuilds a map from stored parts (map/file_read.cpp, import). Ids must be unique and positive; next_id is raised
  /// above them.
  static Map restore(std::vector<MapNode> nodes, KeyframeGraph keyframes, std::map<ClassId, std::string> names,
                     std::int64_t revision, NodeId next_id = 1);

 private:
  struct TileKey {
    ClassId label;
    Tile tile;
    auto operator<=>(const TileKey&) const = default;  // NOLINT(modernize-use-nullptr): a false alarm of clang-tidy 14
  };

  /// What is known of nodes that are out of memory.
  struct PagedOut {
    bool was_active = true;  // all the time since
    bool was_moved = false;  // by a loop
  };
  /// What takeChanges() has to tell.
  struct Changed {
    bool is_tracked = false;
    std::set<KeyframeId> anchors;    // of nodes that came, went or changed
    std::set<KeyframeId> keyframes;  // that came or moved
    std::size_t constraints = 0;     // so many are as they were
  };

  void insert(MapNode node);
  void erase(NodeId id);
  void indexTile(const MapNode& node);
  void unindexTile(const TileKey& key, NodeId id);
  /// Tells the object graph how a node is now.
  void enterGraph(const MapNode& node);
  /// Moves what is anchored to the keyframes of `moves`.
  void moveNodes(const KeyframeMoves& moves, MapDelta& delta);
  /// True when it lies in another tile now.
  bool moveNode(MapNode& node, const Pose& move);
  void findActive(KeyframeId from, MapDelta& delta);
  /// Tells that something anchored to a keyframe is not what it was.
  void touch(KeyframeId anchor);
  MapPage pageOf(KeyframeId id) const;

  std::map<NodeId, MapNode> nodes_;
  PointIndex means_;
  ObjectGraph graph_;
  std::map<TileKey, std::vector<NodeId>> tiles_;  // more than one where some are not active
  TentativeThings tentative_;
  KeyframeGraph keyframes_;
  PoseCovariances pose_covariances_;           // of keyframes_
  std::vector<bool> active_;                   // keyframes
  std::vector<std::vector<NodeId>> anchored_;  // to each keyframe
  std::map<KeyframeId, PagedOut> paged_out_;
  PointIndex keyframe_places_;
  PointIndex page_places_;  // of paged_out_, with how far their nodes reach
  Changed changed_;
  double drift_reach_ = std::numeric_limits<double>::infinity();
  std::map<ClassId, std::string> class_names_;
  double tile_size_ = 0;
  Micros odometry_delay_us_ = 0;
  std::size_t leaf_count_ = 0;
  NodeId next_id_ = 1;
  std::int64_t revision_ = 0;
};

}  // namespace hgg
