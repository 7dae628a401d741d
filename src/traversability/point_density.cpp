#include "traversability/point_density.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

constexpr double kSquare = 2;  // m: a LiDAR's density changes little within it
/// A sheet with less than this share of the density around it is none. Segmenters scatter 0.01 (good) to 0.05 (poor)
/// of their points over some twenty wrong classes (docs/simulator.md), which is 0.0005 to 0.0025 for each; real
/// surfaces of one place differ by their angle to the beams and by how long they were in view.
constexpr double kLeastShare = 0.02;

std::int64_t keyOf(std::int64_t x, std::int64_t y) { return x * (std::int64_t{1} << 32) + y; }

std::int64_t squareOf(double v) { return static_cast<std::int64_t>(std::floor(v / kSquare)); }

}  // namespace

double densityOf(const LeafSheet& sheet) {
  constexpr double kFoot = 0.1;  // m, its edge
  return sheet.kappa * kFootArea / areaOf(sheet, kFoot);
}

void PointDensity::add(const LeafSheet& sheet) {
  Square& square = squares_[keyOf(squareOf(sheet.centre.x()), squareOf(sheet.centre.y()))];
  square.kappa += sheet.kappa, square.kappa_density += sheet.kappa * densityOf(sheet);
}

bool PointDensity::believes(const LeafSheet& sheet) const {
  const Vec3 half = halfBox(sheet);
  const Vec3 low = sheet.centre - half, high = sheet.centre + half;
  double densest = 0;
  for (std::int64_t x = squareOf(low.x()); x <= squareOf(high.x()); ++x) {
    for (std::int64_t y = squareOf(low.y()); y <= squareOf(high.y()); ++y) {
      if (const auto it = squares_.find(keyOf(x, y)); it != squares_.end() && it->second.kappa > 0) {
        densest = std::max(densest, it->second.kappa_density / it->second.kappa);
      }
    }
  }
  return densityOf(sheet) >= kLeastShare * densest;
}

}  // namespace hgg
