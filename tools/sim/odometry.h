#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/types.h"
#include "frame/frame.h"
#include "sim/random.h"

namespace hgg {

/// What odometry adds to true motion. A bias has the given size and a sign by the seed, and wanders slowly: over about
/// 100 m by a third of its size.
struct OdometryErrors {
  double scale = 0;           // bias, share of every step
  double yaw_deg_per_m = 0;   // bias
  double noise = 0;           // m per sqrt(m), each axis
  double yaw_noise_deg = 0;   // deg per sqrt(m)
  double tilt_noise_deg = 0;  // deg per sqrt(m), roll and pitch each
  double jumps_per_100m = 0;
  double jump = 0.5;        // standard deviation of a jump in x and y, m
  double jump_yaw_deg = 3;  // and in heading
  double dropout = 0;       // share of samples that are missing; the first and the last never are
  bool planar = false;      // height, roll and pitch are not known
};

/// "true", "excellent", "good" and "poor": every log has a channel of each.
const std::vector<std::string>& odometryTrackNames();
/// These and "wheel": encoders without an IMU, 2 % of the way and 1 degree in 10 m off, in the plane.
const std::vector<std::string>& odometryPresetNames();
/// nullopt for other names. Measured over 20 seeds on the street (435 m): 0.12, 0.64 and 3.1 m of error over 100 m, ATE
/// 0.09, 0.52 and 3.3 m.
std::optional<OdometryErrors> odometryPreset(const std::string& name);

/// Odometry poses for true poses: each true step, disturbed; starts at the first true pose.
std::vector<Pose> disturbOdometry(const std::vector<Pose>& T_map_body, const OdometryErrors& errors,
                                  std::uint64_t seed);

/// Whether the odometry of frame `frame` (of `frames`) is missing.
bool isOdometryMissing(const OdometryErrors& errors, std::uint64_t seed, std::size_t frame, std::size_t frames);

}  // namespace hgg
