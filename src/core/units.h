#pragma once

#include <numbers>

namespace hgg {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTau = 2 * kPi;         // rad, a full turn
inline constexpr double kDegree = kPi / 180.0;  // rad

constexpr double square(double x) { return x * x; }

}  // namespace hgg
