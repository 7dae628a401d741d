#pragma once

#include <array>
#include <span>

#include "core/types.h"

namespace hgg {

/// 90 % quantile of the chi-square distribution with 3 degrees of freedom.
inline constexpr double kChiSquare90 = 6.251;
/// A published covariance flatter than this (standard deviation, m) counts as this flat.
inline constexpr double kSmallestDeviation = 1e-4;

/// P(chi-square with 3 degrees of freedom <= x).
double chiSquareCdf(double x);

/// e = d^T C^-1 d of a position error d under its published covariance C.
double normalisedSquare(const Vec3& error, const Mat3& position_cov);

/// Whether beliefs keep their word. For honest ones normalised squares follow chi-square with 3 degrees of freedom.
struct Calibration {
  std::size_t count = 0;
  double mean_over_3 = 0;    // mean normalised square / 3; honest: 1, above: overconfident. NaN without objects
  double median_over_3 = 0;  // honest: 0.789; unmoved by a few bad objects
  double inside_90 = 0;      // share inside the 90 % region
  /// Share of objects inside the region that should hold (k + 1) * 5 %.
  std::array<double, 19> inside{};
  /// m, root mean square over objects and axes of the published standard deviation: honest beliefs can still be vague.
  double mean_sigma = 0;  // NaN without objects
};

/// `position_variances`, m^2: of each object, the mean of its published covariance's diagonal.
Calibration calibrate(std::span<const double> normalised_squares, std::span<const double> position_variances);

}  // namespace hgg
