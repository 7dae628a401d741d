#include "place/outline.h"

#include <algorithm>

#include "core/units.h"

namespace hgg {
namespace {

using Eigen::Vector2d;

// Chosen by hand, of the size of a piece of furniture.
constexpr double kEdge = 0.25;    // m: middles of one thing in two maps differ by this much
constexpr double kMargin = 0.75;  // m: a thing at the edge takes up that much ground beyond its middle

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// One side of the hull of points in ascending order (Andrew's monotone chain), its last point left out.
template <typename Points>
std::vector<Vector2d> sideOf(const Points& points) {
  std::vector<Vector2d> side;
  for (const Vector2d& p : points) {
    while (side.size() >= 2 && cross(side.back() - side[side.size() - 2], p - side.back()) <= 0) {
      side.pop_back();
    }
    side.push_back(p);
  }
  if (!side.empty()) {
    side.pop_back();
  }
  return side;
}

/// Area of the hull widened by the margin (Steiner's formula for convex figures).
double widenedArea(const std::vector<Vector2d>& corners) {
  double area = 0, around = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector2d &p = corners[k], &q = corners[(k + 1) % corners.size()];
    area += cross(p, q) / 2;
    around += (q - p).norm();
  }
  return area + kMargin * around + kPi * square(kMargin);
}

}  // namespace

Outline outlineOf(std::span<const Landmark> landmarks) {
  std::vector<Vector2d> points;
  for (const Landmark& l : landmarks) {
    points.emplace_back(l.mean.head<2>());
  }
  std::ranges::sort(
      points, [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  Outline outline;
  outline.corners = sideOf(points);
  std::ranges::reverse(points);
  for (const Vector2d& p : sideOf(points)) {
    outline.corners.push_back(p);
  }
  outline.room = widenedArea(outline.corners);
  return outline;
}

bool isSurveyed(const Outline& outline, const Vec3& p) {
  const std::vector<Vector2d>& corners = outline.corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector2d along = corners[(k + 1) % corners.size()] - corners[k];
    if (!(cross(along, p.head<2>() - corners[k]) >= kEdge * along.norm())) {
      return false;
    }
  }
  return corners.size() > 2;
}

}  // namespace hgg
