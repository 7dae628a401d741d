#pragma once

#include <array>

#include "core/types.h"

namespace hgg {

/// How a sensor is mounted on the body: its origin in m, then roll, pitch and yaw in degrees, turned about the body's
/// fixed axes x, y and z in this order.
struct Mounting {
  double x = 0, y = 0, z = 0, roll_deg = 0, pitch_deg = 0, yaw_deg = 0;

  bool operator==(const Mounting&) const = default;
};

/// The six numbers in their order, and back.
std::array<double, 6> numbersOf(const Mounting& mounting);
Mounting mountingOf(const std::array<double, 6>& numbers);

/// T_body_sensor.
Pose poseOf(const Mounting& mounting);

}  // namespace hgg
