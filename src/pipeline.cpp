#include "pipeline.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "frame/motion.h"

namespace hgg {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

PairingLimits pairingLimits(const FrameConfig& config, OdometryWait wait) {
  PairingLimits limits;
  if (wait == OdometryWait::kConfigured) {
    limits.wait_us = std::llround(config.odometry_wait_ms * 1e3);
  }
  limits.max_gap_us = std::llround(config.odometry_gap_s * 1e6);
  return limits;
}

}  // namespace

Pipeline::Pipeline(Mapper& mapper, OnFrame on_frame, OdometryWait wait, const std::optional<Rig>& rig)
    : mapper_(mapper),
      on_frame_(std::move(on_frame)),
      assembler_(pairingLimits(mapper.config().frame, wait)),
      rig_(rig ? std::make_unique<RigInput>(*rig, mapper.config()) : nullptr) {
  if (mapper_.config().frame.estimate_delay) {
    delay_.startFrom(mapper_.map().odometryDelay_us());
    assembler_.setDelay(delay_.applied_us());
  }
}

void Pipeline::addOdometry(Bytes message, Micros arrival_us) {
  inputs_.add(mapper_.config().lcm.odometry, arrival_us, message);
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
  inputs_.add(mapper_.config().lcm.lidar_semantic, arrival_us, message);
  const auto utime_us = rig_ ? rig_->addMain(message, arrival_us, assembler_) : decode(message, arrival_us);
  if (!utime_us) {
    ++counts_.decode_errors["cloud: " + utime_us.error];
    ++counts_.drops.invalid;
    ++counts_.drops.causes["cloud: unreadable"];
    return;
  }
  decode_ms_[*utime_us] = millisecondsSince(start);
}

/// The time of a labelled cloud, which goes to the assembler.
Result<Micros> Pipeline::decode(Bytes message, Micros arrival_us) {
  auto cloud = decodeSemanticCloud(message, static_cast<float>(mapper_.config().frame.min_confidence));
  if (!cloud) {
    return Result<Micros>::fail(cloud.error);
  }
  if (const Mounting& mounting = mapper_.config().T_body_lidar.lidar_semantic; mounting != Mounting{}) {
    moveToBody(*cloud, poseOf(mounting));
  }
  if (!mapper_.config().frame.deskew) {
    cloud->times.clear();
  }
  const Micros utime_us = cloud->utime_us;
  assembler_.addCloud(std::move(*cloud), arrival_us);
  return Result<Micros>::ok(utime_us);
}

void Pipeline::addRigMessage(const std::string& channel, Bytes message, Micros arrival_us) {
  const auto start = Clock::now();
  inputs_.add(channel, arrival_us, message);
  rig_->addSide(channel, message, arrival_us, assembler_);
  rig_ms_ += millisecondsSince(start);
}

std::optional<Frame> Pipeline::next(Micros now_us) {
  if (rig_) {
    return rig_->next(now_us, assembler_, delay_.applied_us());
  }
  auto frame = assembler_.next(now_us);
  if (frame && !frame->times.empty() && !deskew(*frame, assembler_.odometry(), delay_.applied_us())) {
    ++counts_.skewed;
  }
  return frame;
}

void Pipeline::stepReady(Micros now_us) {
  delay_.compare(assembler_.odometry());
  for (;;) {
    const auto start = Clock::now();
    const auto frame = next(now_us);
    if (!frame) {
      break;
    }
    step(*frame, millisecondsSince(start));
    assembler_.setDelay(delay_.applied_us());
    mapper_.setOdometryDelay(delay_.applied_us());
  }
  if (!assembler_.isWaiting() && !(rig_ && rig_->isWaiting())) {
    decode_ms_.clear();
  }
}

void Pipeline::finish(Micros now_us) {
  assembler_.finish();
  if (rig_) {
    rig_->finish();
  }
  stepReady(now_us);
}

/// `prepare_ms`: what it cost to make the frame of its cloud, beside decoding that.
void Pipeline::step(const Frame& frame, double prepare_ms) {
  const auto start = Clock::now();
  const StepReport report = mapper_.step(frame);
  const double step_ms = millisecondsSince(start);
  if (mapper_.config().frame.estimate_delay) {
    delay_.add(frame.utime_us, report.T_last_body ? std::optional<Mat3>(report.T_last_body->linear()) : std::nullopt);
  }
  ++counts_.frames;
  counts_.unknown_labels += static_cast<std::int64_t>(report.unknown_labels);
  counts_.nonfinite_points += static_cast<std::int64_t>(report.nonfinite_points);
  const double decode_ms = decode_ms_[frame.utime_us] + (rig_ ? 0 : prepare_ms);
  decode_ms_.erase(decode_ms_.begin(), decode_ms_.upper_bound(frame.utime_us));
  FrameTiming timing{decode_ms + step_ms, {{"decode", decode_ms}}};
  if (rig_) {
    const double label_ms = prepare_ms + std::exchange(rig_ms_, 0);
    timing.frame_ms += label_ms;
    timing.stage_ms.emplace_back("label", label_ms);
  }
  timing.stage_ms.insert(timing.stage_ms.end(), report.stage_ms.begin(), report.stage_ms.end());
  if (on_frame_) {
    on_frame_(report, timing);
  }
}

RunCounts Pipeline::counts() const {
  RunCounts counts = counts_;
  counts.drops.odometry += assembler_.drops().odometry;
  counts.drops.invalid += assembler_.drops().invalid;
  for (const auto& [cause, clouds] : assembler_.drops().causes) {
    counts.drops.causes[cause] += clouds;
  }
  const OdometryBuffer& odometry = assembler_.odometry();
  counts.odometry_delay_s = 1e-6 * static_cast<double>(delay_.applied_us());
  counts.odometry_rejected = odometry.counts().rejected();
  counts.odometry_outliers = odometry.counts().outliers;
  counts.odometry_anew = odometry.counts().anew;
  counts.odometry_interval_us = odometry.usualInterval_us();
  counts.odometry_gap_us = assembler_.longestGap_us();
  counts.restarts = assembler_.restarts();
  if (rig_) {
    counts.rig = rig_->counts();
  }
  counts.oddities = inputs_.oddities(mapper_.config().lcm);
  return counts;
}

}  // namespace hgg
