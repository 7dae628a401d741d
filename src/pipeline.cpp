#include "pipeline.h"

#include <chrono>
#include <cmath>
#include <utility>

namespace hgg {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

Pipeline::Pipeline(Mapper& mapper, OnFrame on_frame)
    : mapper_(mapper),
      on_frame_(std::move(on_frame)),
      assembler_(std::llround(mapper.config().frame.odometry_wait_ms * 1000)) {}

void Pipeline::addOdometry(Bytes message) {
  const auto sample = decodePose(message);
  if (!sample) {
    ++counts_.decode_errors["odometry: " + sample.error];
    return;
  }
  ++counts_.odometry_samples;
  assembler_.addOdometry(*sample);
}

void Pipeline::addCloud(Bytes message, Micros arrival_us) {
  const auto start = Clock::now();
  auto cloud = decodeSemanticCloud(message, static_cast<float>(mapper_.config().frame.min_confidence));
  if (!cloud) {
    ++counts_.decode_errors["cloud: " + cloud.error];
    ++counts_.drops.invalid;
    return;
  }
  decode_ms_[cloud->utime_us] = millisecondsSince(start);
  assembler_.addCloud(std::move(*cloud), arrival_us);
}

void Pipeline::stepReady(Micros now_us) {
  while (const auto frame = assembler_.next(now_us)) {
    step(*frame);
  }
  if (!assembler_.isWaiting()) {
    decode_ms_.clear();
  }
}

void Pipeline::step(const Frame& frame) {
  const auto start = Clock::now();
  const StepReport report = mapper_.step(frame);
  const double step_ms = millisecondsSince(start);
  ++counts_.frames;
  counts_.unknown_labels += static_cast<std::int64_t>(report.unknown_labels);
  counts_.nonfinite_points += static_cast<std::int64_t>(report.nonfinite_points);
  const double decode_ms = decode_ms_[frame.utime_us];
  decode_ms_.erase(decode_ms_.begin(), decode_ms_.upper_bound(frame.utime_us));
  FrameTiming timing{decode_ms + step_ms, {{"decode", decode_ms}}};
  timing.stage_ms.insert(timing.stage_ms.end(), report.stage_ms.begin(), report.stage_ms.end());
  if (on_frame_) {
    on_frame_(report, timing);
  }
}

RunCounts Pipeline::counts() const {
  RunCounts counts = counts_;
  counts.drops.odometry += assembler_.drops().odometry;
  counts.drops.invalid += assembler_.drops().invalid;
  counts.odometry_rejected = assembler_.odometry().rejected();
  counts.restarts = assembler_.restarts();
  return counts;
}

}  // namespace hgg
