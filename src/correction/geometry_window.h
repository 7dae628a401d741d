#pragma once

#include <deque>
#include <vector>

#include "config.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// The points of the last keyframes by the nodes they belong to, with which EM refines leaves. The only place where raw
/// points outlive their frame, and not for long.
class GeometryWindow {
 public:
  /// Takes the points of a new keyframe's frame; `pairs` are its objects' nodes. `frames` went into the map since the
  /// keyframe before.
  void add(KeyframeId keyframe, const LocalGraph& local, const std::vector<ObjectPair>& pairs, int frames,
           const Config& config);

  /// Nodes with refined leaves: of those in the window the ones whose turn it is, each once in a window's length.
  /// Poses, object frames and the beliefs over whole objects stay as they are.
  std::vector<MapNode> refine(const Map& map, const Config& config) const;

 private:
  struct Part {
    NodeId id = 0;
    std::vector<Eigen::Vector3f> points_body;
  };
  struct View {
    KeyframeId keyframe = -1;
    double point_weight = 1;  // measured points that one stands for
    std::vector<Part> parts;  // ascending by id
  };

  std::deque<View> views_;
};

}  // namespace hgg
