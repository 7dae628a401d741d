#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "correction/loop_closer.h"
#include "frame/frame.h"
#include "frame/rig_counts.h"
#include "map/map.h"
#include "mapper.h"

namespace hgg {

/// What one frame cost, decode included.
struct FrameTiming {
  double frame_ms = 0;
  std::vector<std::pair<std::string, double>> stage_ms;  // in order of the pipeline
};

/// Quantiles of a stream of positive values in constant memory: logarithmic bins, 0.5 % wide, so quantiles are right to
/// 0.25 %.
class Distribution {
 public:
  void add(double value);
  /// 0 when empty.
  double quantile(double q) const;
  double mean() const { return count_ > 0 ? sum_ / static_cast<double>(count_) : 0; }
  double max() const { return max_; }

 private:
  std::vector<std::uint32_t> bins_;
  std::uint64_t count_ = 0;
  double sum_ = 0, max_ = 0;
};

/// A value per frame as a curve of bounded size: neighbouring frames share a bin, and bins double their width when they
/// become too many. Means and maxima stay exact.
class FrameCurve {
 public:
  struct Bin {
    std::int64_t last_frame = 0, count = 0;  // frames are numbered from 1
    double sum = 0, max = 0;
    double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
  };

  explicit FrameCurve(std::size_t max_bins) : max_bins_(max_bins) {}
  /// The value of the next frame.
  void add(double value);
  /// At most max_bins, oldest first; all but the last hold the same number of frames.
  const std::vector<Bin>& bins() const { return bins_; }

 private:
  void halve();

  std::size_t max_bins_;
  std::vector<Bin> bins_;
  std::int64_t frames_ = 0, bin_width_ = 1;
};

/// Everything that happened to the messages of a run or a replay.
struct RunCounts {
  std::int64_t frames = 0;  // stepped
  FrameDrops drops;
  std::int64_t unknown_labels = 0, nonfinite_points = 0;     // points
  std::int64_t odometry_samples = 0, odometry_rejected = 0;  // decoded; of those late, duplicate or out of line
  double odometry_delay_s = 0;                               // by which odometry's stamps lag behind, as estimated
  std::int64_t odometry_outliers = 0;                        // of the rejected: those with a stamp out of line
  std::int64_t odometry_anew = 0;                            // times the odometry began anew
  Micros odometry_interval_us = 0;                           // usual time between samples; 0: not known
  Micros odometry_gap_us = 0;                                // longest gap between samples that cost a cloud; 0: none
  std::int64_t restarts = 0;                                 // times that time went back between frames
  std::map<std::string, std::int64_t> decode_errors;         // "cloud: truncated" -> messages
  std::int64_t skewed = 0;                                   // clouds that odometry could not deskew
  std::optional<RigCounts> rig;                              // of a run whose clouds come from a rig
  std::vector<std::string> oddities;                         // what else looks wrong with the inputs, a line each
};

/// How often the robot did not know where it was, and what was wrong with odometry; in frames.
struct TrackingCounts {
  std::int64_t recovered = 0, doubtful = 0;  // frames found in a wider search, and left out because they did not fit
  std::int64_t apart = 0;                    // frames in a fragment that was not joined yet
  KeyframeId fragment = 0;                   // of the last frame
  std::map<std::string, std::int64_t> odometry_faults;  // by their code

  void add(const StepReport& report);
};

/// Accumulates the cost of a run over its frames.
class RunStats {
 public:
  void add(const FrameTiming& timing, double map_mb);
  void add(const StepReport& report) { tracking_.add(report); }
  /// stats.json (keys in docs/operations.md). The memory and time curves have at most 200 points each.
  std::string json(const RunCounts& counts, const Map& map, const LoopCloser& loops) const;

 private:
  struct MemorySample {
    std::int64_t frame = 0;
    double map_mb = 0, rss_mb = 0;
  };

  static constexpr std::size_t kCurvePoints = 200;

  TrackingCounts tracking_;
  Distribution frame_ms_;
  FrameCurve time_{kCurvePoints};
  std::map<std::string, Distribution> stage_ms_;
  std::vector<MemorySample> memory_;
  std::int64_t frames_ = 0, sample_every_ = 1;
};

/// Resident set of this process now, MB; 0 where /proc does not tell.
double residentMegabytes();

}  // namespace hgg
