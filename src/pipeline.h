#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/codec.h"
#include "frame/assemble.h"
#include "frame/odometry_delay.h"
#include "inputs.h"
#include "mapper.h"
#include "rig_input.h"
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
  /// `on_frame` is called after each step and may be empty. `mapper` must outlive the pipeline. With a `rig` the clouds
  /// come without labels, and the mapper's config is configFor() it.
  Pipeline(Mapper& mapper, OnFrame on_frame, OdometryWait wait, const std::optional<Rig>& rig = std::nullopt);

  /// `arrival_us` and `now_us` are of one clock, any clock: the log's or the receiver's.
  void addOdometry(Bytes message, Micros arrival_us);
  void addCloud(Bytes message, Micros arrival_us);
  /// Of another sensor of the rig, where isRigChannel().
  void addRigMessage(const std::string& channel, Bytes message, Micros arrival_us);
  bool isRigChannel(const std::string& channel) const { return rig_ && rig_->isSideChannel(channel); }
  std::vector<std::string> rigChannels() const { return rig_ ? rig_->sideChannels() : std::vector<std::string>{}; }
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
  Result<Micros> decode(Bytes message, Micros arrival_us);
  std::optional<Frame> next(Micros now_us);
  void step(const Frame& frame, double prepare_ms);

  Mapper& mapper_;
  OnFrame on_frame_;
  InputWatch inputs_;
  FrameAssembler assembler_;
  std::unique_ptr<RigInput> rig_;
  OdometryDelay delay_;
  std::map<Micros, double> decode_ms_;  // of clouds that wait, by their time
  double rig_ms_ = 0;                   // of messages of the rig that came since the last frame
  RunCounts counts_;                    // without the assembler's share
};

}  // namespace hgg
