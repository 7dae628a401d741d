#pragma once

#include <random>
#include <vector>

#include "core/types.h"
#include "frame/frame.h"

namespace hgg {

/// A row of parked cars and poles beside a straight road, seen by a body that drives along it: enough of a world to
/// make a map of.
class SmallWorld {
 public:
  static constexpr Micros kPeriod_us = 100'000;
  static constexpr Micros kStart_us = 1'000'000;

  static Micros timeOf(int i) { return kStart_us + i * kPeriod_us; }

  static OdometrySample odometry(int i) {
    OdometrySample sample{timeOf(i), Pose::Identity()};
    sample.T_odom_body.translation().x() = i;
    return sample;
  }

  /// Frame `i` in the body frame; the same points for the same `i`.
  static std::vector<Point> points(int i) {
    std::mt19937 random(static_cast<unsigned>(i));
    std::uniform_real_distribution<float> unit(-0.5f, 0.5f);
    std::vector<Point> points;
    const auto body_x = static_cast<float>(i);
    for (int k = 0; k < 10; ++k) {
      const auto x = static_cast<float>(8 * k);
      if (std::abs(x - body_x) > 25) {
        continue;
      }
      for (int n = 0; n < 120; ++n) {
        points.push_back({x - body_x + 4 * unit(random), 5 + 1.8f * unit(random), unit(random), 0, 10});
      }
      for (int n = 0; n < 60; ++n) {
        points.push_back({x - body_x + 0.2f * unit(random), -6 + 0.2f * unit(random), 2 * unit(random), 0, 80});
      }
    }
    for (int n = 0; n < 2000; ++n) {
      points.push_back({40 * unit(random), 6 * unit(random), -1.5f + 0.02f * unit(random), 0, 40});
    }
    return points;
  }
};

}  // namespace hgg
