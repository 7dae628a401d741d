#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "alignment/tracker.h"
#include "config.h"
#include "core/se3.h"
#include "correction/corrector.h"
#include "frame/frame.h"
#include "map/map.h"
#include "map/movers.h"

namespace hgg {

/// What one step did and cost.
struct StepReport {
  Micros utime_us = 0;
  Pose T_map_body = Pose::Identity();
  Pose T_map_odom = Pose::Identity();
  Pose T_keyframe_body = Pose::Identity();  // in the frame of `keyframe`
  MapDelta delta;                           // of the step as a whole
  std::vector<Mover> moving;                // what moves, ascending by id; those that were seen a second ago too
  std::vector<NodeId> stopped;              // ascending: ids of what was among them before
  PoseSource source = PoseSource::kOdometry;
  Tracking tracking = Tracking::kHeld;
  OdometryFault odometry_fault = OdometryFault::kNone;
  KeyframeId fragment = 0;          // of the map that the robot is in, named by its oldest keyframe; 0: the first one
  Mat6 pose_cov = Mat6::Zero();     // of T_map_body against the part of the map around it: m^2, rad^2
  std::optional<Pose> T_last_body;  // the motion since the last frame; nullopt unless the map has aligned both
  int degenerate = 0;               // directions in which it is odometry's
  std::string paging_trouble;       // what is wrong with keeping far parts of the map; empty: nothing
  KeyframeId keyframe = -1;         // the pose moves with this one
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

  /// Where the robot starts in a stored map, known to 0.3 m and 3 degrees. Without it the first frame begins a new
  /// fragment of map, which is joined to the stored one when loop closure recognises the place. Call before the first
  /// step.
  void startAt(const Pose& T_map_body) { T_map_start_ = T_map_body; }

  StepReport step(const Frame& frame);
  /// At the end of a drive, before the map is stored: completes what correction is still at work on.
  void finish();

  const Map& map() const { return map_; }
  /// How what is paged out is read; empty where all of the map is in memory.
  const PageReader& pageReader() const { return corrector_.pages().read; }
  /// What has changed of the map since the last call, or all there is in memory, to be written (map/page_keeper.h).
  /// Nothing is noted before trackChanges() was called.
  void trackChanges() { map_.trackChanges(); }
  MapChanges takeChanges(bool all) { return map_.takeChanges(all); }
  /// To be stored with the map.
  void setOdometryDelay(Micros delay_us) { map_.setOdometryDelay(delay_us); }
  const Config& config() const { return config_; }
  const ClassTable& classes() const { return classes_; }
  const LoopCloser& loops() const { return corrector_.loops(); }
  const Movers& movers() const { return movers_; }

 private:
  /// Where the frame is expected; begins a new fragment of map where nothing tells.
  Prediction propagate(const Frame& frame, MapDelta& delta);
  /// Whether the frame lies on the map as aligned; where it does not, and while odometry is unproven, it is looked for
  /// in a wider search. Where that gives another graph of the frame, what was `taken` out of the first is in it.
  Tracking track(const Frame& frame, const Prediction& prediction, LocalGraph& local, Alignment& alignment,
                 std::vector<LocalObject>& taken);
  /// Follows what moves: its objects leave the frame's graph and alignment's pairs, the nodes it had made the map.
  MapDelta follow(const std::shared_ptr<const FreeSpace>& free, LocalGraph& local, Alignment& alignment,
                  const std::vector<LocalObject>& taken, StepReport& report);
  /// The frame fused into the map.
  MapDelta update(const Frame& frame, const LocalGraph& local, const Alignment& alignment, const FreeSpace& free,
                  const KeyframeDecision& keyframe);
  /// Whether a loop has joined the fragment to the first one.
  void followFragment(int loops_before);
  void describePose(const Alignment& alignment, StepReport& report) const;

  Config config_;
  ClassTable classes_;
  Map map_;
  Corrector corrector_;
  Tracker tracker_;
  Movers movers_;
  Pose T_map_odom_ = Pose::Identity();
  std::optional<Pose> T_map_start_;
  KeyframeId fragment_ = 0;
};

}  // namespace hgg
