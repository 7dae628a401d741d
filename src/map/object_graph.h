#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/belief.h"
#include "core/point_index.h"
#include "map/max_tree.h"
#include "map/node.h"

namespace hgg {

/// How edges are weighed (eq. rel_weights): w = c S1 / S1max + (1 - c) S2.
struct EdgeModel {
  double sigma_floor = 0.01;    // m, under flat extents (S1)
  double geometry_share = 0.5;  // c
};

/// The relative neighbourhood graph over the confirmed nodes of a map: i and j are neighbours when no third node is
/// nearer to both than they are to each other. Kept exactly, by recomputing what a change can have touched.
///
/// Why that is enough. When the neighbours of a node i are computed, every other node is either found to be one or
/// ruled out by a blocker, a node between the two. The proof radius of i is the distance of the farthest blocker that
/// was needed. So each pair that is no edge has an end (the one computed last) that knows a blocker of it within its
/// proof radius, and each edge has an end that holds it among its neighbours. Now some nodes come, go or move. Those
/// are computed anew where they are, with all of their pairs. Take a pair of two others:
///  - It was no edge, and becomes one only if its blocker went away. The blocker was within the proof radius of one of
///    the ends: the nodes that had a changed node within their proof radius, where it was before, are computed anew.
///  - It was an edge, and ends only if a node came between. That node is nearer to both ends than they are to each
///    other: edges of nodes whose longest edge is longer than their distance to a changed node, where it is now, are
///    compared with it.
/// Both are questions for the nodes within whose reach (the larger of proof radius and longest edge) a place lies,
/// which the index answers in the time it takes to name them. Nothing depends on the size of the map.
///
/// A closed loop moves thousands of nodes at once. Their positions are right at once; their edges stay as they are
/// until they are taken in over the frames that follow (postpone()), those around the robot first. That is as good:
/// neighbours are always computed from where nodes are at that time, so a node that is computed after another has moved
/// knows of it, whether that move has been taken in or not, and one that was computed before is found when it is taken
/// in, by where the other has been. A node that has postponed changes of its own is left alone until then. When nothing
/// is postponed any more the graph is what it would be from scratch.
class ObjectGraph {
 public:
  struct Neighbor {
    NodeId id = 0;
    ClassId label = 0;
    double s1 = 0;  // eq. metric, m / m; S2 is whether the labels differ
    int handle = -1;
  };

  /// Empties the graph. Without a model there is none: nodes are not taken.
  void setModel(const EdgeModel& model);
  bool hasModel() const { return model_.has_value(); }
  const std::optional<EdgeModel>& model() const { return model_; }

  /// A node as it is now, that is or becomes part of the graph.
  void put(NodeId id, ClassId label, const Belief& belief);
  /// A node that was moved, if it is part of it.
  void move(NodeId id, const Belief& belief);
  /// A node that may have been part of it and is not any more.
  void remove(NodeId id);
  enum class Postponed : std::uint8_t { kLeave, kTakeSome };  // a frame's share of it
  /// Takes in what was put and removed since, and a share of what was postponed if it is asked for. Returns the nodes,
  /// ascending, that have other neighbours or another S1 to one than before; removed ones are not among them.
  std::vector<NodeId> refresh(Postponed postponed);
  /// Leaves what was put since to later refreshes, what is nearest to `first` first.
  void postpone(const Vec3& first);
  /// Takes in everything, and names nothing: for a map that begins, ends or is stored.
  void settle();
  bool isSettled() const { return fresh_.empty() && postponed_.empty(); }

  std::size_t size() const { return index_.size(); }
  bool holds(NodeId id) const { return index_.find(id) >= 0; }
  /// Neighbours of a node, ascending; none for one that is not in the graph. Valid until the next change.
  std::span<const Neighbor> neighborsOf(NodeId id) const;
  /// The neighbours that a node at p would have, ascending by id; their S1 is not known (0).
  std::vector<Neighbor> neighborsAt(const Vec3& p) const;
  /// Edges with an end among `ids` (ascending), in ascending order.
  std::vector<Edge> edgesOf(const std::vector<NodeId>& ids) const;
  /// All edges, in ascending order.
  std::vector<Edge> edges() const;
  /// How often the neighbours of a node have been computed: what the graph costs, whatever the machine.
  std::int64_t computations() const { return computations_; }

 private:
  struct Node {
    Mat3 cov = Mat3::Zero();  // m^2
    ClassId label = 0;
    double square_proof = 0;  // of the proof radius, m^2
    std::vector<Neighbor> neighbors;
    int postponed = 0;                                    // changes of it that have not been taken in
    std::int64_t marked = 0, computed = 0, measured = 0;  // the last rounds in which its neighbours, or all S1, were
  };
  enum class Kind : std::uint8_t { kCame, kMoved, kReshaped, kWent };
  struct Change {
    NodeId id = 0;
    Kind kind = Kind::kCame;
    Vec3 from = Vec3::Zero();  // where it was before, or came
    std::int64_t round = 0;    // the last one before it: whatever was computed later knows of it
  };

  Node& node(int handle) { return nodes_[static_cast<std::size_t>(handle)]; }
  const Node& node(int handle) const { return nodes_[static_cast<std::size_t>(handle)]; }
  Belief beliefOf(int handle) const { return {index_.position(handle), node(handle).cov, 0}; }
  Edge edgeOf(NodeId id, const Node& of, const Neighbor& to) const;

  void change(int handle, const Belief& belief);
  void takeIn(std::span<const Change> changes);
  void rebuild();
  void mark(int handle);
  void disturb(const Change& change);
  void cutBlocked(int handle, int blocker);
  void unlink(int a, int b);
  void compute(int handle);
  void measure(int handle, bool anew);
  void updateLargest(int handle);

  std::optional<EdgeModel> model_;
  PointIndex index_;
  std::vector<Node> nodes_;                // by their handle in the index
  MaxTree largest_s1_;                     // of the edges of each node
  std::vector<Change> fresh_, postponed_;  // the latter: the next one last
  std::vector<NodeId> rewired_;
  std::vector<int> marked_;  // to be computed in this round
  std::vector<int> found_;
  std::int64_t round_ = 0, computations_ = 0;
};

}  // namespace hgg
