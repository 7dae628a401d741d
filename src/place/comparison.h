#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/classes.h"
#include "map/map.h"
#include "place/consistency.h"
#include "place/surfaces.h"

namespace hgg {

/// A map as zero-shot alignment sees it. Labels are those of map a, one for each name.
struct ComparisonSide {
  std::vector<const MapNode*> nodes;                             // ascending by id
  std::vector<std::size_t> things;                               // indices into nodes
  std::vector<Landmark> landmarks;                               // one a thing, in their order
  std::vector<double> trust;                                     // one a thing, 0 .. 1: its existence
  std::vector<Surface> surfaces;                                 // leaves of all nodes, map frame, in their order
  std::vector<std::pair<std::size_t, std::size_t>> surfaces_of;  // one a node: first, last + 1
  double grain = 0;                                              // m, typical size of a leaf
};

/// Two maps and what is needed to compare them. Refers to both maps.
struct Comparison {
  ComparisonSide a, b;
  Similarity similarity;
  double reach = 0;  // m: a map has surveyed what has one of its leaves this near; 0 when either has no usable leaf
  std::optional<SurfaceIndex> index_a, index_b, wide_index_a;  // of one reach, the last of two

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
