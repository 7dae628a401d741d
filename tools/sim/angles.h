#pragma once

#include <numbers>

namespace hgg {

inline constexpr double kTau = 2.0 * std::numbers::pi;       // rad, a full turn
inline constexpr double kDegree = std::numbers::pi / 180.0;  // rad

}  // namespace hgg
