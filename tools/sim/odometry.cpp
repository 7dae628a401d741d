#include "sim/odometry.h"

#include <cmath>

#include "core/units.h"
#include "sim/sensor.h"

namespace hgg {
namespace {

constexpr double kWander = 0.3;          // standard deviation of a bias, as a share of its size
constexpr double kWanderLength = 100.0;  // m: of the memory of its wandering

/// Numbers of one step.
class StepNoise {
 public:
  enum Use : std::uint64_t { kX, kY, kZ, kYaw, kRoll, kPitch, kScaleWander, kYawWander, kJumpX, kJumpY, kJumpYaw };

  StepNoise(std::uint64_t seed, std::size_t step) : key_(keyFor(seed, Purpose::kOdometry, 0, step)) {}
  double operator()(Use use) const { return gaussian(key_, use); }
  bool isJump(double probability) const { return uniform(key_, 100) < probability; }
  bool isMissing(double probability) const { return uniform(key_, 101) < probability; }

 private:
  RandomKey key_;
};

/// Mean 1 with the sign of the seed; wanders as an Ornstein-Uhlenbeck process over the way.
class Wander {
 public:
  Wander(std::uint64_t seed, StepNoise::Use use)
      : sign_(StepNoise(seed, 0)(use) < 0 ? -1.0 : 1.0), deviation_(StepNoise(seed, 1)(use)), use_(use) {}

  double next(double length, const StepNoise& noise) {
    const double keep = std::exp(-length / kWanderLength);
    deviation_ = keep * deviation_ + std::sqrt(1.0 - keep * keep) * noise(use_);
    return sign_ * (1.0 + kWander * deviation_);
  }

 private:
  double sign_, deviation_;
  StepNoise::Use use_;
};

Mat3 rotation(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
          Eigen::AngleAxisd(roll, Vec3::UnitX()))
      .toRotationMatrix();
}

/// The step as a body feels it that knows no height and no tilt.
Pose inPlane(const Pose& step) {
  Pose flat = Pose::Identity();
  flat.translation().head<2>() = step.translation().head<2>();
  flat.linear() = rotation(0, 0, std::atan2(step.linear()(1, 0), step.linear()(0, 0)));
  return flat;
}

/// `scale` and `yaw` are the biases of this step, share and rad.
Pose disturbStep(const Pose& step, const OdometryErrors& errors, double scale, double yaw, const StepNoise& noise) {
  const double length = step.translation().norm(), root = std::sqrt(length);
  Pose disturbed = step;
  disturbed.translation() *= 1.0 + scale;
  disturbed.translation() +=
      errors.noise * root * Vec3(noise(StepNoise::kX), noise(StepNoise::kY), noise(StepNoise::kZ));
  const double tilt = kDegree * errors.tilt_noise_deg * root;
  yaw += kDegree * errors.yaw_noise_deg * root * noise(StepNoise::kYaw);
  if (noise.isJump(errors.jumps_per_100m * length / 100.0)) {
    disturbed.translation() += errors.jump * Vec3(noise(StepNoise::kJumpX), noise(StepNoise::kJumpY), 0.0);
    yaw += kDegree * errors.jump_yaw_deg * noise(StepNoise::kJumpYaw);
  }
  disturbed.rotate(rotation(tilt * noise(StepNoise::kRoll), tilt * noise(StepNoise::kPitch), yaw));
  return errors.planar ? inPlane(disturbed) : disturbed;
}

}  // namespace

const std::vector<std::string>& odometryTrackNames() {
  static const std::vector<std::string> names{"true", "excellent", "good", "poor"};
  return names;
}

const std::vector<std::string>& odometryPresetNames() {
  static const std::vector<std::string> names{"true", "excellent", "good", "poor", "wheel"};
  return names;
}

std::optional<OdometryErrors> odometryPreset(const std::string& name) {
  if (name == "true") {
    return OdometryErrors{};
  }
  if (name == "excellent") {
    return OdometryErrors{
        .scale = 0.0015, .yaw_deg_per_m = 0.001, .noise = 0.003, .yaw_noise_deg = 0.005, .tilt_noise_deg = 0.002};
  }
  if (name == "good") {
    return OdometryErrors{
        .scale = 0.008, .yaw_deg_per_m = 0.007, .noise = 0.01, .yaw_noise_deg = 0.03, .tilt_noise_deg = 0.005};
  }
  if (name == "poor") {
    return OdometryErrors{
        .scale = 0.02, .yaw_deg_per_m = 0.05, .noise = 0.03, .yaw_noise_deg = 0.1, .tilt_noise_deg = 0.02};
  }
  if (name == "wheel") {
    return OdometryErrors{.scale = 0.02, .yaw_deg_per_m = 0.1, .noise = 0.01, .yaw_noise_deg = 0.1, .planar = true};
  }
  return std::nullopt;
}

std::vector<Pose> disturbOdometry(const std::vector<Pose>& T_map_body, const OdometryErrors& errors,
                                  std::uint64_t seed) {
  std::vector<Pose> odometry;
  Wander scale_wander(seed, StepNoise::kScaleWander), yaw_wander(seed, StepNoise::kYawWander);
  for (std::size_t i = 0; i < T_map_body.size(); ++i) {
    if (i == 0) {
      odometry.push_back(T_map_body[0]);
      continue;
    }
    const StepNoise noise(seed, i + 1);
    const Pose step = T_map_body[i - 1].inverse() * T_map_body[i];
    const double length = step.translation().norm();
    const double scale = errors.scale * scale_wander.next(length, noise);
    const double yaw = kDegree * errors.yaw_deg_per_m * length * yaw_wander.next(length, noise);
    odometry.push_back(odometry.back() * disturbStep(step, errors, scale, yaw, noise));
  }
  return odometry;
}

bool isOdometryMissing(const OdometryErrors& errors, std::uint64_t seed, std::size_t frame, std::size_t frames) {
  return frame > 0 && frame + 1 < frames && StepNoise(seed, frame + 1).isMissing(errors.dropout);
}

}  // namespace hgg
