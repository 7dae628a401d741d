#include "eval/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/spd.h"

namespace hgg {

double chiSquareCdf(double x) {
  return x <= 0 ? 0.0 : std::erf(std::sqrt(x / 2)) - std::sqrt(2 * x / std::numbers::pi) * std::exp(-x / 2);
}

double normalisedSquare(const Vec3& error, const Mat3& position_cov) {
  const Eigen3 e = eigenSymmetric(position_cov);
  const Vec3 variances = e.values.cwiseMax(kSmallestDeviation * kSmallestDeviation);
  const Vec3 along = e.vectors.transpose() * error;
  return along.cwiseAbs2().cwiseQuotient(variances).sum();
}

Calibration calibrate(std::span<const double> normalised_squares, std::span<const double> position_variances) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  Calibration c{normalised_squares.size(), kNothing, kNothing, kNothing, {}, kNothing};
  if (normalised_squares.empty()) {
    c.inside.fill(kNothing);
    return c;
  }
  std::vector<double> e(normalised_squares.begin(), normalised_squares.end());
  std::ranges::sort(e);
  const auto n = static_cast<double>(e.size());
  c.mean_over_3 = std::accumulate(e.begin(), e.end(), 0.0) / n / 3;
  c.mean_sigma = std::sqrt(std::accumulate(position_variances.begin(), position_variances.end(), 0.0) / n);
  c.median_over_3 = 0.5 * (e[(e.size() - 1) / 2] + e[e.size() / 2]) / 3;
  c.inside_90 = static_cast<double>(std::ranges::upper_bound(e, kChiSquare90) - e.begin()) / n;
  for (std::size_t k = 0; k < c.inside.size(); ++k) {
    const double share = 0.05 * static_cast<double>(k + 1);
    c.inside[k] = static_cast<double>(std::ranges::count_if(e, [&](double x) { return chiSquareCdf(x) <= share; })) / n;
  }
  return c;
}

}  // namespace hgg
