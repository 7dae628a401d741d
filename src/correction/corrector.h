#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "alignment/align.h"
#include "alignment/odometry_trust.h"
#include "config.h"
#include "core/classes.h"
#include "correction/between.h"
#include "correction/geometry_window.h"
#include "correction/loop_closer.h"
#include "correction/pose_window.h"
#include "map/local_graph.h"
#include "map/map.h"
#include "map/paging.h"

namespace hgg {

/// What correction came to.
struct Correction {
  MapDelta delta;   // of all that was applied, the map update before it included
  PoseBelief pose;  // of the present frame: it moves rigidly with the last keyframe
};

/// Whether a frame becomes a keyframe, or takes one up again that is there.
struct KeyframeDecision {
  std::optional<NewKeyframe> added;
  KeyframeId taken_up = -1;
};

/// The correction stage. It decides which frames become keyframes, and at each keyframe corrects the map in turn by
///   the pose window     (eq. fgo):           poses of the last keyframes,
///   the geometry window (eqs e-step, m-step): leaves of the nodes they saw,
///   loop closure:                            poses of all keyframes.
/// Nodes that a correction or a keyframe has brought together are merged, a bounded number of them a frame.
///
/// Each correction is computed on the map as the one before it has left it: EM, for one, lays the points of the window
/// where the pose window has put them. So correct() is given the map itself and not a copy of it, and applies what its
/// parts return; like everyone it changes the map through Map::apply() only.
class Corrector {
 public:
  Corrector(const Config& config, const ClassTable& classes, LoopTiming timing, PageStore pages = {});

  /// Describes the places of a stored map. Call it before the first frame, while all of the map is active.
  void start(const Map& stored);

  /// Brings back what a frame at `p_map` may meet. Call it before the frame is aligned.
  MapDelta bringBackAround(Map& map, const Vec3& p_map);

  /// Pages out what is far from `p_map` while the map is larger than its budget, no more than `most` pages; where the
  /// store takes none, detail is given up.
  MapDelta makeRoom(Map& map, const Vec3& p_map, std::size_t most);
  /// The door to what is out of memory.
  const PageStore& pages() const { return pages_; }

  /// Whether an aligned frame becomes a keyframe, and with which constraints, or is at an older one that is taken up
  /// again, so that a map that is driven through again and again does not grow. Call it once for each frame, before the
  /// map update that carries it. T_last_body is the motion since the last frame; `is_jump`: odometry gave no usable
  /// one.
  KeyframeDecision decideKeyframe(const Map& map, const LocalGraph& local, const Alignment& alignment,
                                  const Pose& T_last_body, bool is_jump, const NoiseScale& odometry);

  /// The robot is somewhere unknown: begins a new fragment of map at a keyframe that is tied to the last one as loosely
  /// as that. Everything from before is out of reach until loop closure recognises it.
  MapDelta beginFragment(Map& map, Micros utime_us, const Pose& T_map_body);
  /// Whether fragments can be joined again: they are by loop closure.
  bool canJoinFragments() const { return config_.correction.loop_closure; }

  /// Corrects the map after a frame's update, `updated` being what that changed. Without a keyframe only pending merges
  /// are worked off; at one that was taken up again windows are left alone, too.
  Correction correct(Map& map, MapDelta updated, const KeyframeDecision& keyframe, const LocalGraph& local,
                     const Alignment& alignment);

  /// At the end of a drive, before the map is stored: waits for the loop that is being verified and works off all
  /// pending merges. `pose` is that of the last frame. What is out of memory stays there if it can be read from there.
  Correction finish(Map& map, const PoseBelief& pose);

  const LoopCloser& loops() const { return loops_; }

 private:
  void refinePoses(Map& map, const LocalGraph& local, const Alignment& alignment, Correction& correction);
  void refineLeaves(Map& map, const LocalGraph& local, const Alignment& alignment, Correction& correction);
  /// Applies a correction and merges what it has brought together.
  void apply(Map& map, const MapCorrection& moves, Correction& correction);
  void closeLoop(Map& map, Correction& correction);
  /// Brings back what may lie around a place, m, as part of the correction.
  void bringBackInto(Correction& correction, Map& map, const Vec3& centre, double radius);
  double mergeDistance() const;   // m
  double residentRadius() const;  // m
  /// Notes the nodes that `delta` has brought together with others.
  void notePending(const MapDelta& delta);
  /// Merges the first of all that wait.
  void mergePending(Map& map, Correction& correction);
  void mergeAll(Map& map, Correction& correction);

  Config config_;
  ClassTable classes_;
  PageStore pages_;
  PoseWindow pose_window_;
  GeometryWindow geometry_window_;
  LoopCloser loops_;
  Travel travel_;                       // since the last keyframe
  int frames_ = 0;                      // since the last keyframe
  std::vector<NodeId> pending_merges_;  // ascending
};

}  // namespace hgg
