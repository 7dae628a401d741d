#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/belief.h"
#include "core/types.h"
#include "map/node.h"

namespace hgg {

/// A leaf Gaussian of a frame's geometry graph, in the object frame.
using LocalLeaf = Belief;

/// An object of one frame, in the body frame. The object frame T_body_object has its origin at the mean and its axes
/// along the eigenvectors of the extent.
struct LocalObject {
  ClassId label = 0;
  std::uint32_t instance = 0;  // the segmenter's, 0 = none
  bool stuff = false;
  Tile tile;  // stuff only: map-frame tile under the predicted pose
  Belief belief;
  Pose T_body_object = Pose::Identity();
  std::vector<LocalLeaf> leaves;
  std::size_t begin = 0, end = 0;  // its points in LocalGraph::points
};

/// A cluster of a frame that has too few points to be an object of its own: a thing that is small or far away, or
/// points with wrong labels. What it is shows over several frames (map/tentative.h). Body frame.
struct SmallCluster {
  ClassId label = 0;
  Belief belief;
};

/// G_t: the objects of one frame, made without looking at the map.
struct LocalGraph {
  Micros utime_us = 0;
  std::vector<LocalObject> objects;
  std::vector<SmallCluster> small;
  /// Relative neighbourhood graph over the means, pairs (i < j). Its weights (eq. rel_weights) are left out: nobody
  /// asks for those of a frame, and the map's graph weighs its own edges.
  std::vector<std::pair<int, int>> edges;
  std::vector<PackedPoint> points;  // body frame, without those that were left out and counted below
  std::size_t nonfinite_points = 0, out_of_range_points = 0, ignored_points = 0, unknown_labels = 0;
};

/// A local object matched to a map node.
struct ObjectPair {
  int local = 0;
  NodeId map = 0;
  double cost = 0;  // eq. cost, m; 0 for stuff
};

}  // namespace hgg
