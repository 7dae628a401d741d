#pragma once

#include <cmath>

#include "core/belief.h"

namespace hgg {

/// A leaf as the surface it stands for: a flat ellipse with the same covariance along its two largest axes. The
/// smallest axis is how far the points lay off the surface.
struct LeafSheet {
  Vec3 centre = Vec3::Zero();  // frame of the leaf
  Vec3 along = Vec3::UnitX(), across = Vec3::UnitY(), normal = Vec3::UnitZ();
  double half_along = 0, half_across = 0;  // m: the ellipse, two standard deviations
  double thickness = 0;                    // m, standard deviation along the normal
  double kappa = 0;
};

LeafSheet sheetOf(const Belief& leaf);

/// Area of the ellipse, m^2, at least that of a square of edge `least` (m): a line has none.
double areaOf(const LeafSheet& sheet, double least);

/// Half the edges of the box around the ellipse, m.
inline Vec3 halfBox(const LeafSheet& sheet) {
  return (sheet.half_along * sheet.along).cwiseAbs() + (sheet.half_across * sheet.across).cwiseAbs();
}

/// Calls visit(p) for points spread evenly over the sheet, neighbours at most `spacing` (m) apart: rows across the
/// ellipse, each shifted by the golden ratio against the one before, so that no pattern of a voxel grid meets a
/// pattern of samples. At least one point; the same points for the same sheet.
template <typename Visit>
void forEachSample(const LeafSheet& sheet, double spacing, Visit visit) {
  constexpr double kGolden = 0.6180339887498949;  // fractional part of the golden ratio
  const int rows = 1 + static_cast<int>(2 * sheet.half_across / spacing);
  double shift = 0.5;
  for (int row = 0; row < rows; ++row) {
    const double across = rows == 1 ? 0 : sheet.half_across * ((2 * row + 1.0) / rows - 1);
    const double share = sheet.half_across > 0 ? across / sheet.half_across : 0;
    const double half = sheet.half_along * std::sqrt(1 - share * share);
    const int count = 1 + static_cast<int>(2 * half / spacing);
    const Vec3 row_centre = sheet.centre + across * sheet.across;
    for (int k = 0; k < count; ++k) {
      visit(Vec3(row_centre + half * (2 * (k + shift) / count - 1) * sheet.along));
    }
    shift = shift + kGolden - std::floor(shift + kGolden);
  }
}

}  // namespace hgg
