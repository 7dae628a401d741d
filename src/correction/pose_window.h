#pragma once

#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "alignment/align.h"
#include "correction/window.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// The sliding window of eq. fgo: what the last ten keyframes saw of things. Its variables are the keyframes' poses and
/// the objects; only the poses are given back. Objects follow their keyframes: their beliefs are merges of all that was
/// seen, which the points' evidence determines better than a mean over single observations does.
class PoseWindow {
 public:
  /// Takes what a new keyframe of `map` saw and how it was aligned.
  void add(const Map& map, KeyframeId keyframe, const LocalGraph& local, const Alignment& alignment);

  /// The keyframes' poses as the window finds them. nullopt when the window has fewer than two keyframes or cannot be
  /// solved, and when leaves of the map have aligned the newest keyframe: leaves determine it better than objects do.
  /// `leaf_size` (m) is the map's.
  std::optional<MapCorrection> solve(const Map& map, double leaf_size, const WindowConfig& config) const;

 private:
  struct Keyframe {
    KeyframeId id = -1;
    bool is_aligned = false;  // by leaves of the map, if only in some directions
    std::vector<std::pair<NodeId, Belief>> seen_body;
    std::vector<BetweenConstraint> constraints;  // to older keyframes, as measured; the map's are reset by the window
  };

  /// Needs a keyframe. Its poses are those of the window's keyframes, in their order.
  WindowProblem problemOf(const Map& map, double leaf_size) const;
  /// Merges what a keyframe that leaves the window saw into what is known of the objects from before the window.
  void moveToPrior(const Map& map, const Keyframe& keyframe);

  std::deque<Keyframe> keyframes_;   // oldest first
  std::map<NodeId, Belief> before_;  // the window's objects as they were before the window, in the object frame
};

}  // namespace hgg
