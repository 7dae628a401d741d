#pragma once

#include <string>
#include <utility>
#include <vector>

#include "config.h"
#include "map/map.h"
#include "place/zero_shot.h"

namespace hgg {

/// How two of several maps lie to each other.
struct MapPair {
  std::size_t a = 0, b = 0;  // in the order the maps were given
  ZeroShot found;
};

/// What became of several maps.
struct MergedMaps {
  bool accepted = false;
  std::string reason;
  Map map;                        // all of them in the frame of the first, if accepted
  std::vector<MapPair> pairs;     // all that were compared
  std::vector<Pose> T_first_map;  // of each map, as a whole; if accepted
  std::size_t places = 0;         // at which two maps were laid onto each other in detail
  std::size_t joined = 0;         // nodes that have become part of another
};

/// Joins maps of one place: every map is aligned with every other without an initial pose (place/zero_shot.h), the
/// keyframes of all of them are laid out by one pose graph, and nodes that are one object are merged by their beliefs
/// as after a closed loop. It is refused where a map is recognised in none of the others, or where recognitions
/// contradict each other: joining maps that do not belong together spoils both. The order of the maps decides the frame
/// and the ids that are kept, and nothing else that matters. `maps`: two or more, of one tile size.
MergedMaps mergeMaps(const std::vector<Map>& maps, const ClassTable& classes, const Config& config);

}  // namespace hgg
