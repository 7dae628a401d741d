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

PairingLimits pairingLimits(const FrameConfig& config, OdometryWait wait) {
  PairingLimits limits;
  if (wait == OdometryWait::kConfigured) {
    limits.wait_us = std::llround(config.odometry_wait_ms * 1e3);
  }
  limits.max_gap_us = std::llround(config.odometry_gap_s * 1e6);
  return limits;
}

/// Takes a cloud from the frame of its sensor to that of the body.
void moveToBody(SemanticCloud& cloud, const Pose& T_body_sensor) {
  const Eigen::Isometry3f T = T_body_sensor.cast<float>();
  for (Point& p : cloud.points) {
    const Eigen::Vector3f v = T * Eigen::Vector3f(p.x, p.y, p.z);
    p.x = v.x(), p.y = v.y(), p.z = v.z();
  }
  cloud.p_body_sensor = T_body_sensor.translation();
}

}  // namespace

Pipeline::Pipeline(Mapper& mapper, OnFrame on_frame, OdometryWait wait)
    : mapper_(mapper), on_frame_(std::move(on_frame)), assembler_(pairingLimits(mapper.config().frame, wait)) {
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
  auto cloud = decodeSemanticCloud(message, static_cast<float>(mapper_.config().frame.min_confidence));
  if (!cloud) {
    ++counts_.decode_errors["cloud: " + cloud.error];
    ++counts_.drops.invalid;
    ++counts_.drops.causes["cloud: unreadable"];
    return;
  }
  if (const Mounting& mounting = mapper_.config().T_body_lidar.lidar_semantic; mounting != Mounting{}) {
    moveToBody(*cloud, poseOf(mounting));
  }
  decode_ms_[cloud->utime_us] = millisecondsSince(start);
  assembler_.addCloud(std::move(*cloud), arrival_us);
}

void Pipeline::stepReady(Micros now_us) {
  delay_.compare(assembler_.odometry());
  while (const auto frame = assembler_.next(now_us)) {
    step(*frame);
    assembler_.setDelay(delay_.applied_us());
    mapper_.setOdometryDelay(delay_.applied_us());
  }
  if (!assembler_.isWaiting()) {
    decode_ms_.clear();
  }
}

void Pipeline::finish(Micros now_us) {
  assembler_.finish();
  stepReady(now_us);
}

void Pipeline::step(const Frame& frame) {
  const auto start = Clock::now();
  const StepReport report = mapper_.step(frame);
  const double step_ms = millisecondsSince(start);
  if (mapper_.config().frame.estimate_delay) {
    delay_.add(frame.utime_us, report.T_last_body ? std::optional<Mat3>(report.T_last_body->linear()) : std::nullopt);
  }
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
  counts.oddities = inputs_.oddities(mapper_.config().lcm);
  return counts;
}

}  // namespace hgg
