#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/classes.h"
#include "map/map.h"
#include "place/candidates.h"
#include "place/outline.h"
#include "place/surfaces.h"

namespace hgg {

/// One of two maps, prepared for the comparison. Labels are those of map a, one for each name.
struct ComparisonSide {
  std::vector<const MapNode*> nodes;                             // ascending by id
  std::vector<std::size_t> things;                               // indices into nodes
  std::vector<Landmark> landmarks;                               // one for each thing, in the order of `things`
  std::vector<double> trust;                                     // one for each thing, 0 .. 1: its existence
  std::vector<Surface> surfaces;                                 // leaves of all nodes, map frame, node after node
  std::vector<std::pair<std::size_t, std::size_t>> surfaces_of;  // one for each node: first, last + 1
  double grain = 0;                                              // m, typical size of a leaf
  Outline outline;                                               // of the things
};

/// Two maps and what is needed to compare them. Refers to both maps, which have to outlive it.
struct Comparison {
  ComparisonSide a, b;
  Similarity similarity;
  /// A map has surveyed a place when one of its leaves lies this near (m); 0 when either map has no usable leaf. The
  /// indices are there when it is above 0.
  double survey_distance = 0;
  std::optional<SurfaceIndex> index_a, index_b;

  /// One of the maps has no leaf at all, as graphs from elsewhere (`hggmap import`): things are all there is to
  /// compare.
  bool by_things = false;

  /// Classes of map b are taken for those of a with the same name; where a map carries no names, with the same id.
  /// `similar` names others that may be one.
  Comparison(const Map& map_a, const Map& map_b, std::span<const SimilarClasses> similar);
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  bool areLike(ClassId label_a, ClassId label_b) const {
    return label_a == label_b || similarity(label_a, label_b) > 0;
  }
};

}  // namespace hgg
