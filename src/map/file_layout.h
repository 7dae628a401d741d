#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "core/types.h"

namespace hgg {

/// Names and limits that the writer and the reader of map files share; the layout itself is described in map/file.h.

static_assert(std::endian::native == std::endian::little, "the file is written as it lies in memory");

inline constexpr std::string_view kMapMagic = "HGGMAP\r\n";
inline constexpr std::string_view kMapEnd = "END.";
/// A map is written in the oldest of these versions that holds it: its bytes do not depend on what it lacks.
inline constexpr std::uint32_t kMapVersion = 7, kMapVersionWithoutFreeSpace = 6, kMapVersionWithoutLooks = 5;
/// What versions up to these lack.
inline constexpr std::uint32_t kVersionWithoutExpected = 3, kVersionWithoutConstraints = 2, kVersionWithoutClasses = 1;
/// Bits of a node's looks, and of what was seen through it.
inline constexpr std::uint8_t kHasColour = 1, kHasFront = 2, kHasFreeSpace = 4;
inline constexpr std::size_t kMapFrameBytes = 4U << 20;  // of the payload in one zstd frame

/// Entries of a symmetric matrix in the order of the file.
inline constexpr std::pair<Eigen::Index, Eigen::Index> kMapCovarianceOrder[] = {{0, 0}, {1, 1}, {2, 2},
                                                                                {0, 1}, {0, 2}, {1, 2}};

/// What a between constraint may leave open. Beyond these limits its information is no number that a solver can use:
/// 1e-6 m squared and inverted is 1e12, a thousandth of what double precision tells from 1.
struct SigmaLimits {
  double least = 0, most = 0;
};
inline constexpr SigmaLimits kSigmaLimits{1e-6, 1e3}, kSigmaTurnLimits{1e-7, 1e3};  // m, rad

/// Odometry that lags more has another clock, us.
inline constexpr Micros kLongestDelay_us = 10'000'000;

}  // namespace hgg
