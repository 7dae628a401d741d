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

  RunCounts counts() const;

 private:
  void step(const Frame& frame);

  Mapper& mapper_;
  OnFrame on_frame_;
  FrameAssembler assembler_;
  std::map<Micros, double> decode_ms_;  // of clouds that wait, by their time
  RunCounts counts_;                    // without the assembler's share
};

}  // namespace hgg
