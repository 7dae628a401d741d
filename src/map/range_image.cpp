#include "map/range_image.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/// Standard deviations along the beam from the mean to where a thing ends for sure: one in a thousand lies beyond.
constexpr double kDepthSigmas = 3;
/// The same across, where what lies beyond is only not counted: seven in eight points lie within.
constexpr double kSideSigmas = 2;
/// Bins along either side of a footprint that are looked at, spread evenly over it: bounds the work.
constexpr int kMostSamples = 5;

struct Face {
  unsigned index;
  Vec3 forward, left;
};

/// The face that a direction meets.
Face faceOf(const Vec3& p) {
  if (std::abs(p.x()) >= std::abs(p.y())) {
    return p.x() < 0 ? Face{1, -Vec3::UnitX(), -Vec3::UnitY()} : Face{0, Vec3::UnitX(), Vec3::UnitY()};
  }
  return p.y() < 0 ? Face{3, -Vec3::UnitY(), Vec3::UnitX()} : Face{2, Vec3::UnitY(), -Vec3::UnitX()};
}

/// Bins of one axis from `first` to `last`, each `step`th.
struct Samples {
  int first, last, step;
};

Samples samplesOf(double middle, double half, int bins) {
  const int first = std::max(static_cast<int>(std::floor(middle - half)), 0);
  const int last = std::min(static_cast<int>(std::floor(middle + half)), bins - 1);
  const int step = std::max((last - first + kMostSamples) / kMostSamples, 1);
  return {first, last, step};
}

}  // namespace

RangeImage::RangeImage(const Vec3& p_body_sensor)
    : sensor_{static_cast<float>(p_body_sensor.x()), static_cast<float>(p_body_sensor.y()),
              static_cast<float>(p_body_sensor.z())},
      bins_(static_cast<std::size_t>(4 * kRows * kColumns)) {}

BeamCount RangeImage::beamsAt(const Vec3& p_sensor, const Mat3& cov, double sigma) const {
  const Face face = faceOf(p_sensor);
  const double depth = face.forward.dot(p_sensor);
  const double variance = sigma * sigma;
  const double reach = kDepthSigmas * std::sqrt(std::max(face.forward.dot(cov * face.forward), 0.0) + variance);
  const double before = depth - reach, behind = depth + reach;
  BeamCount count;
  if (before < static_cast<double>(kNearest) || behind > static_cast<double>(kFarthest)) {
    return count;  // the sensor is as good as in it
  }
  // The Gaussian as it is seen: in bins, by the slopes' first order about its mean.
  const double per_metre = static_cast<double>(kBinsPerUnit) / depth;
  const Vec2 slope(face.left.dot(p_sensor) / depth, p_sensor.z() / depth);
  Eigen::Matrix<double, 2, 3> J;
  J.row(0) = per_metre * (face.left - slope[0] * face.forward).transpose();
  J.row(1) = per_metre * (Vec3::UnitZ() - slope[1] * face.forward).transpose();
  const Mat2 seen = J * cov * J.transpose();
  Mat2 spread = seen;  // and by where in its bin a beam lies, and by sigma
  spread.diagonal().array() += variance * per_metre * per_metre + 1.0 / 12;
  const double chance = std::sqrt(std::max(seen.determinant(), 0.0) / spread.determinant());
  const Mat2 inverse = spread.inverse();
  const Vec2 middle = slope * static_cast<double>(kBinsPerUnit) +
                      Vec2(static_cast<double>(kBinsPerUnit), static_cast<double>(kHalfRows));
  const Samples columns = samplesOf(middle[0], kSideSigmas * std::sqrt(spread(0, 0)), kColumns);
  const Samples rows = samplesOf(middle[1], kSideSigmas * std::sqrt(spread(1, 1)), kRows);
  for (int row = rows.first; row <= rows.last; row += rows.step) {
    const Bin* line = &bins_[(face.index * kRows + static_cast<unsigned>(row)) * kColumns];
    for (int column = columns.first; column <= columns.last; column += columns.step) {
      const Bin& bin = line[column];
      const double nearest = static_cast<double>(bin.nearest) / static_cast<double>(kUnitsPerMetre);
      if (bin.beams == 0) {
        continue;
      }
      const Vec2 d = Vec2(column + 0.5, row + 0.5) - middle;
      const double about = bin.beams * std::exp(-0.5 * d.dot(inverse * d)), beams = chance * about;
      count.ends += nearest >= before && nearest <= behind ? about : 0;
      (nearest > behind ? count.through : nearest < before ? count.hidden : count.hits) += beams;
    }
  }
  const double sampled = rows.step * columns.step;
  count.through *= sampled, count.hits *= sampled, count.hidden *= sampled, count.ends *= sampled;
  return count;
}

}  // namespace hgg
