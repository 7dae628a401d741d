#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "alignment/align.h"
#include "config.h"
#include "correction/window.h"
#include "map/local_graph.h"
#include "map/map.h"

namespace hgg {

/// What the last keyframes saw of things: the sliding window of eq. fgo. Its variables are the keyframes' poses and the
/// objects; what it gives back are the poses. Objects follow them: their beliefs are merges of all that was seen, which
/// the points' evidence determines better than a mean of views does.
class PoseWindow {
 public:
  /// Takes what a new keyframe saw and how it was aligned.
  void add(const Map& map, KeyframeId keyframe, const LocalGraph& local, const Alignment& alignment);

  /// The keyframes where the window has them; nullopt when it is too short or not usable, and where the map holds the
  /// newest pose: leaves say more than objects do.
  std::optional<MapCorrection> solve(const Map& map, const Config& config) const;

 private:
  struct View {
    KeyframeId keyframe = -1;
    bool is_held = false;  // by leaves of the map, if only in some directions: the rest odometry knows better
    std::vector<std::pair<NodeId, Belief>> seen_body;
    std::vector<BetweenConstraint> constraints;  // to older keyframes, as measured: those of the map follow the window
  };

  /// Needs a view. Its poses are those of the views, in their order.
  WindowProblem problemOf(const Map& map, const Config& config) const;
  /// Lets what a view says of objects be from before the window.
  void leaveBehind(const Map& map, const View& view);

  std::deque<View> views_;
  std::map<NodeId, Belief> before_;  // objects of the views as they were before the window, in the object frame
};

}  // namespace hgg
