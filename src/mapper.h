#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config.h"
#include "core/se3.h"
#include "correction/between.h"
#include "correction/geometry_window.h"
#include "correction/loop_closer.h"
#include "correction/pose_window.h"
#include "frame/frame.h"
#include "map/map.h"

namespace hgg {

/// What one step did and cost.
struct StepReport {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
  Pose T_map_odom = Pose::Identity();
  Pose T_keyframe_body = Pose::Identity();  // in the frame of `keyframe`
  MapDelta delta;                           // of the step as a whole
  PoseSource source = PoseSource::kOdometry;
  int degenerate = 0;                                    // directions in which it is odometry's
  KeyframeId keyframe = -1;                              // the pose moves with this one
  std::vector<std::pair<std::string, double>> stage_ms;  // in order of the pipeline
  std::size_t points = 0;                                // kept points
  std::size_t unknown_labels = 0;                        // points with a label outside the class table
  std::size_t nonfinite_points = 0;
};

/// Why a stored map cannot go on under this config and class table (other tiles, classes of another kind); empty when
/// it can.
std::string explainMismatch(const Map& map, const Config& config, const ClassTable& classes);

/// The paper's system figure: frame -> creation -> alignment -> map update -> correction.
class Mapper {
 public:
  Mapper(Config config, ClassTable classes, Map map = {}, LoopTiming timing = LoopTiming::kFixed);

  StepReport step(const Frame& frame);
  /// At the end of a drive, before the map is stored: takes what correction is still at work on.
  void finish();

  const Map& map() const { return map_; }
  const Config& config() const { return config_; }
  const ClassTable& classes() const { return classes_; }
  const LoopCloser& loops() const { return loops_; }

 private:
  /// The last refined pose and the odometry it came with.
  struct Aligned {
    PoseBelief pose;
    Pose T_odom_body;
  };

  /// Where odometry says the body is, before the map is asked.
  std::optional<PoseBelief> predict(const Pose& T_odom_body) const;
  /// Map update and what has to be done at once.
  MapDelta update(const Frame& frame, const LocalGraph& local, const Alignment& alignment, bool is_jump);
  /// Correction at a new keyframe.
  MapDelta correct(const LocalGraph& local, const Alignment& alignment);
  /// Merges what may have come to lie on something else: a few at a time, however much a loop has reactivated.
  MapDelta mergePending(MapDelta delta);
  /// Applies a correction; the present pose goes with the last keyframe.
  MapDelta carryOut(const MapCorrection& correction);

  Config config_;
  ClassTable classes_;
  Map map_;
  PoseWindow pose_window_;
  GeometryWindow geometry_window_;
  LoopCloser loops_;
  Pose T_map_odom_ = Pose::Identity();
  std::optional<Aligned> last_;
  Travel travel_;                       // since the last keyframe
  int frames_ = 0;                      // since the last keyframe
  std::vector<NodeId> pending_merges_;  // still to be merged, ascending
};

}  // namespace hgg
