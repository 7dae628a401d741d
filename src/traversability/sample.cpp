#include "traversability/sample.h"

#include <algorithm>

#include "core/spd.h"
#include "core/units.h"

namespace hgg {

LeafSheet sheetOf(const Belief& leaf) {
  const Eigen3 e = eigenSymmetric(leaf.cov);
  const Vec3 deviations = e.values.cwiseMax(0).cwiseSqrt();
  LeafSheet sheet;
  sheet.centre = leaf.mean;
  sheet.normal = e.vectors.col(0), sheet.across = e.vectors.col(1), sheet.along = e.vectors.col(2);
  // A uniform ellipse reaches two standard deviations far along each of its axes.
  sheet.half_across = 2 * deviations[1], sheet.half_along = 2 * deviations[2];
  sheet.thickness = deviations[0];
  sheet.kappa = leaf.kappa;
  return sheet;
}

double areaOf(const LeafSheet& sheet, double least) {
  return std::max(kPi * std::max(sheet.half_along, least / 2) * std::max(sheet.half_across, least / 2), square(least));
}

}  // namespace hgg
