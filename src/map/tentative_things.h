#pragma once

#include <cstdint>
#include <vector>

#include "core/belief.h"
#include "core/types.h"
#include "map/node.h"

namespace hgg {

/// A place where clusters of one class were seen that are too small to be objects. Map frame; moves rigidly with its
/// anchor keyframe.
struct TentativeThing {
  ClassId label = 0;
  Belief belief;  // all points of the clusters
  KeyframeId anchor = -1;
  double found = 0;        // views that had a cluster there
  double missed = 0;       // views that looked there and had none
  double found_again = 0;  // of the finds, those after the first stretch of views
  std::int32_t frames = 0;
  Micros first_us = 0, last_us = 0;
};

/// The tentative things of a map, and what has become of others. Not stored: a session begins without.
struct TentativeThings {
  std::vector<TentativeThing> list;  // in the order of their beginning
  double begun = 0;                  // so far
  /// Of those that were dropped: misses and finds after their first stretch, and the finds among these. Their ratio is
  /// how often noise repeats at one place.
  double looks_at_noise = 0, repeats_of_noise = 0;
};

}  // namespace hgg
