#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "map/node.h"

namespace hgg {

/// A group of things that belong together: what stands in one room, a row of parked cars, what stands on a square. A
/// node of the level above objects, made by the same formulas (region/regions.h).
struct Region {
  std::int64_t id = 0;          // that of its oldest thing
  std::string name;             // for people, by what it holds
  Belief belief;                // of its things, merged (eq. merge); map frame
  std::vector<NodeId> objects;  // ascending
};

/// The third level of the graph.
struct Regions {
  std::vector<Region> regions;  // ascending by id
  std::vector<Edge> edges;      // relative neighbourhood graph over the regions, weighed as edges of objects are
};

}  // namespace hgg
