#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace hgg {

/// Randomness by counter: a value depends on its key alone, so it is the same on every platform and in any order of
/// work.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint64_t stream = 0;
};

/// splitmix64's finaliser.
inline std::uint64_t mixBits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Uniform in (0, 1).
inline double uniform(const RandomKey& key, std::uint64_t counter) {
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
  const std::uint64_t bits = mixBits(mixBits(mixBits(key.seed + kGolden) + key.stream + kGolden) + counter + kGolden);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

/// Normal with mean 0 and deviation 1 (Box-Muller).
inline double gaussian(const RandomKey& key, std::uint64_t counter) {
  const double radius = std::sqrt(-2.0 * std::log(uniform(key, 2 * counter)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(key, 2 * counter + 1));
}

}  // namespace hgg
