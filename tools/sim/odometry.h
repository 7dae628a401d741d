#pragma once

#include <vector>

#include "core/types.h"
#include "sim/random.h"

namespace hgg {

/// What odometry adds to true motion, per metre travelled.
struct OdometryError {
  double scale = 0;          // share of every step
  double yaw_deg_per_m = 0;  // bias
  double noise = 0;          // m per sqrt(m), each axis
  double yaw_noise_deg = 0;  // deg per sqrt(m)
};

/// The preset behind `hgg-sim --drift PERCENT`.
OdometryError driftOf(double percent);

/// Odometry poses for true poses: each true step, disturbed; starts at the first true pose.
std::vector<Pose> disturbOdometry(const std::vector<Pose>& T_map_body, const OdometryError& error, std::uint64_t seed);

}  // namespace hgg
