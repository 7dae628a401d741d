#include "sim/world_surface.h"

#include <cmath>

#include "core/units.h"

namespace hgg {
namespace {

using Visit = std::function<void(const Vec3&, const Vec3&)>;

double steps(double length, double spacing) { return std::max(1.0, std::round(length / spacing)); }

/// corner + [0, 1] * u + [0, 1] * v, at the middles of a grid of cells.
void sampleParallelogram(const Vec3& corner, const Vec3& u, const Vec3& v, const Vec3& normal, double spacing,
                         const Visit& point) {
  const double nu = steps(u.norm(), spacing), nv = steps(v.norm(), spacing);
  for (double i = 0; i < nu; ++i) {
    for (double j = 0; j < nv; ++j) {
      point(corner + u * ((i + 0.5) / nu) + v * ((j + 0.5) / nv), normal);
    }
  }
}

void sample(const Plane& plane, double spacing, const Bounds& within, const Visit& point) {
  const Vec3 normal = plane.normal.normalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
  const Vec3 center = 0.5 * (within.lo + within.hi);
  const Vec3 foot = center - normal * normal.dot(center - plane.point);
  const double reach = 0.5 * (within.hi - within.lo).norm();
  sampleParallelogram(foot - reach * (u + v), 2.0 * reach * u, 2.0 * reach * v, Vec3::Zero(), spacing, point);
}

void sample(const Box& box, double spacing, const Bounds& /*within*/, const Visit& point) {
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 R = box.T_world_box.linear();
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const Vec3 out = R.col(axis) * box.half[axis], u = R.col(a) * box.half[a], v = R.col(b) * box.half[b];
    for (const double side : {-1.0, 1.0}) {
      sampleParallelogram(box.T_world_box.translation() + side * out - u - v, 2.0 * u, 2.0 * v, side * R.col(axis),
                          spacing, point);
    }
  }
}

/// `up` 0: the normals point away from the centre.
void sampleRing(const Vec3& center, double radius, double up, double spacing, const Visit& point) {
  const double n = steps(kTau * radius, spacing);
  for (double i = 0; i < n; ++i) {
    const double angle = kTau * (i + 0.5) / n;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    point(center + radius * out, up == 0.0 ? out : Vec3(0.0, 0.0, up));
  }
}

void sample(const Cylinder& cylinder, double spacing, const Bounds& /*within*/, const Visit& point) {
  const double rows = steps(cylinder.height, spacing), rings = steps(cylinder.radius, spacing);
  for (double i = 0; i < rows; ++i) {
    sampleRing(cylinder.base + cylinder.height * ((i + 0.5) / rows) * Vec3::UnitZ(), cylinder.radius, 0.0, spacing,
               point);
  }
  for (double i = 0; i < rings; ++i) {
    const double radius = cylinder.radius * (i + 0.5) / rings;
    sampleRing(cylinder.base, radius, -1.0, spacing, point);
    sampleRing(cylinder.base + cylinder.height * Vec3::UnitZ(), radius, 1.0, spacing, point);
  }
}

/// Rings at equal steps of latitude: even enough for ellipsoids that are nearly round.
void sample(const Ellipsoid& ellipsoid, double spacing, const Bounds& /*within*/, const Visit& point) {
  const double rows = steps(0.5 * kTau * ellipsoid.half.maxCoeff(), spacing);
  for (double i = 0; i < rows; ++i) {
    const double latitude = 0.5 * kTau * ((i + 0.5) / rows - 0.5);
    const double radius = std::cos(latitude), n = steps(kTau * radius * ellipsoid.half.maxCoeff(), spacing);
    for (double k = 0; k < n; ++k) {
      const Vec3 on_sphere(radius * std::cos(kTau * k / n), radius * std::sin(kTau * k / n), std::sin(latitude));
      point(ellipsoid.center + ellipsoid.half.cwiseProduct(on_sphere),
            on_sphere.cwiseQuotient(ellipsoid.half).normalized());
    }
  }
}

/// The middles of those cells of a grid over the whole parallelogram that lie in the triangle.
void sample(const Triangle& triangle, double spacing, const Bounds& /*within*/, const Visit& point) {
  const Vec3 u = triangle.b - triangle.a, v = triangle.c - triangle.a;
  const double nu = steps(u.norm(), spacing), nv = steps(u.cross(v).norm() / u.norm(), spacing);
  if (nu * nv == 1.0) {
    point(triangle.a + (u + v) / 3.0, Vec3::Zero());
    return;
  }
  for (double i = 0; i < nu; ++i) {
    for (double j = 0; j < nv && (i + 0.5) / nu + (j + 0.5) / nv <= 1.0; ++j) {
      point(triangle.a + u * ((i + 0.5) / nu) + v * ((j + 0.5) / nv), Vec3::Zero());
    }
  }
}

}  // namespace

void sampleSurface(const Shape& shape, double spacing, const Bounds& within, const Visit& point) {
  std::visit([&](const auto& s) { sample(s, spacing, within, point); }, shape);
}

std::vector<Vec3> sampleObject(const World& world, std::size_t object, double spacing) {
  std::vector<Vec3> points;
  for (const Solid& solid : world.solids) {
    if (solid.object == object && !std::holds_alternative<Plane>(solid.shape)) {
      sampleSurface(solid.shape, spacing, {}, [&](const Vec3& p, const Vec3& /*normal*/) { points.push_back(p); });
    }
  }
  return points;
}

}  // namespace hgg
