#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config.h"
#include "core/se3.h"
#include "correction/corrector.h"
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

/// The paper's system figure: frame -> propagation -> creation -> alignment -> map update -> correction.
class Mapper {
 public:
  /// `pages`: where parts of the map go that are far from the robot; all of it stays in memory without.
  Mapper(Config config, ClassTable classes, Map map = {}, LoopTiming timing = LoopTiming::kFixed, PageStore pages = {});

  StepReport step(const Frame& frame);
  /// At the end of a drive, before the map is stored: completes what correction is still at work on.
  void finish();

  const Map& map() const { return map_; }
  const Config& config() const { return config_; }
  const ClassTable& classes() const { return classes_; }
  const LoopCloser& loops() const { return corrector_.loops(); }

 private:
  /// The last refined pose and the odometry it came with.
  struct Aligned {
    PoseBelief pose;
    Pose T_odom_body;
  };

  /// The last pose and the odometry since; nullopt at the first frame and where odometry has jumped.
  std::optional<PoseBelief> propagate(const Pose& T_odom_body) const;
  /// The pose to start from where there is none to propagate.
  PoseBelief start(const Pose& T_odom_body);
  /// The frame fused into the map.
  MapDelta update(const LocalGraph& local, const Alignment& alignment, const Pose& T_last_body,
                  const std::optional<NewKeyframe>& keyframe);
  void describePose(const Alignment& alignment, StepReport& report) const;

  Config config_;
  ClassTable classes_;
  Map map_;
  Corrector corrector_;
  Pose T_map_odom_ = Pose::Identity();
  std::optional<Aligned> last_;
};

}  // namespace hgg
