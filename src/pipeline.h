#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "bus/codec.h"
#include "frame/assemble.h"
#include "frame/odometry_delay.h"
#include "inputs.h"
#include "mapper.h"
#include "stats.h"

namespace hgg {

using OnFrame = std::function<void(const StepReport&, const FrameTiming&)>;

/// How long a cloud waits for its odometry: live as the config says (frame.odometry_wait_ms), from a log as long as it
/// goes on.
enum class OdometryWait : std::uint8_t { kConfigured, kUnlimited };

/// What run and replay share: messages in, mapped frames out. The same messages give the same frames on both, but for
/// clouds whose odometry comes later than a live robot waits.
class Pipeline {
 public:
  /// `on_frame` is called after each step and may be empty. `mapper` must outlive the pipeline.
  Pipeline(Mapper& mapper, OnFrame on_frame, OdometryWait wait);

  /// `arrival_us` and `now_us` are of one clock, any clock: the log's or the receiver's.
  void addOdometry(Bytes message, Micros arrival_us);
  void addCloud(Bytes message, Micros arrival_us);
  /// A message of no use here, for the account of what came.
  void addOther(const std::string& channel, Bytes message, Micros arrival_us) {
    inputs_.add(channel, arrival_us, message);
  }
  /// Steps the mapper through every frame that has its odometry.
  void stepReady(Micros now_us);
  /// No more messages will come: steps through the last frames and gives up on clouds without odometry.
  void finish(Micros now_us);
  void countBusy(std::int64_t clouds) { counts_.drops.busy += clouds; }
  /// Of a message that is none of the pipeline's.
  void countUnreadable(const std::string& reason) { ++counts_.decode_errors[reason]; }

  std::int64_t frames() const { return counts_.frames; }
  RunCounts counts() const;
  const InputWatch& inputs() const { return inputs_; }

 private:
  void step(const Frame& frame);

  Mapper& mapper_;
  OnFrame on_frame_;
  InputWatch inputs_;
  FrameAssembler assembler_;
  OdometryDelay delay_;
  std::map<Micros, double> decode_ms_;  // of clouds that wait, by their time
  RunCounts counts_;                    // without the assembler's share
};

}  // namespace hgg
