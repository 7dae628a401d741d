#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "bus/codec.h"
#include "frame/assemble.h"
#include "mapper.h"
#include "stats.h"

namespace hgg {

using OnFrame = std::function<void(const StepReport&, const FrameTiming&)>;

/// Everything that happened to the messages of a run or a replay.
struct PipelineCounts {
  std::int64_t frames = 0;  // stepped
  FrameDrops drops;
  std::int64_t odometry_samples = 0, odometry_rejected = 0;  // decoded; of those late or duplicate
  std::int64_t restarts = 0;                                 // time went back by more than kRestart_us
  std::int64_t unknown_labels = 0, nonfinite_points = 0;
  std::map<std::string, std::int64_t> decode_errors;  // "cloud: truncated" -> messages
};

/// What run and replay share: messages in, mapped frames out. The same messages give the same frames on both.
class Pipeline {
 public:
  /// `on_frame` is called after each step and may be empty. `mapper` must outlive the pipeline.
  Pipeline(Mapper& mapper, OnFrame on_frame);

  void addOdometry(Bytes message);
  /// `arrival_us` and `now_us` are of one clock, any clock: the log's or the receiver's.
  void addCloud(Bytes message, Micros arrival_us);
  /// Steps the mapper through every frame that has its odometry.
  void stepReady(Micros now_us);
  /// Gives up on clouds that still wait for odometry.
  void finish() { assembler_.finish(); }
  void countBusy(std::int64_t clouds) { counts_.drops.busy += clouds; }

  PipelineCounts counts() const;

 private:
  void step(const Frame& frame);

  Mapper& mapper_;
  OnFrame on_frame_;
  FrameAssembler assembler_;
  std::map<Micros, double> decode_ms_;  // of clouds that wait, by their time
  PipelineCounts counts_;               // without the assembler's share
};

}  // namespace hgg
