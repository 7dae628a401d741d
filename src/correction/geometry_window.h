#pragma once

#include <deque>
#include <vector>

#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// The points of the last keyframes by the nodes they belong to, with which EM refines leaves. This is the only place
/// where raw points outlive their frame, for five keyframes and at 12 bytes a point.
class GeometryWindow {
 public:
  /// Takes the points of a new keyframe's frame, at most `max_points` of them evenly spread; `pairs` are its objects'
  /// nodes. `frames` frames went into the map since the keyframe before.
  void add(KeyframeId keyframe, const LocalGraph& local, const std::vector<ObjectPair>& pairs, int frames,
           int max_points);

  /// Nodes with refined leaves: those seen in the window whose turn it is, each once in the length of a window. Poses,
  /// object frames, the beliefs over whole objects and the total evidence of a node's leaves stay as they are.
  /// `sigma_floor` (m) is the floor of a leaf's standard deviations.
  std::vector<MapNode> refine(const Map& map, double sigma_floor) const;

 private:
  /// The points of one node that a keyframe saw.
  struct NodePoints {
    NodeId id = 0;
    std::vector<Eigen::Vector3f> points_body;
  };
  struct Keyframe {
    KeyframeId id = -1;
    double point_weight = 1;        // measured points that one kept point stands for
    std::vector<NodePoints> nodes;  // ascending by id
  };

  std::deque<Keyframe> keyframes_;  // oldest first
};

}  // namespace hgg
