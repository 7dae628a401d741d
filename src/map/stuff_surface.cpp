#include "map/stuff_surface.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/spd.h"

namespace hgg {
namespace {

/// How far around an object the stuff is asked for its plane: as far as two neighbouring beams of a sparse LiDAR lie
/// apart on a wall. m
constexpr double kAround = 0.5;
/// Half of an object's box, in standard deviations of its points.
constexpr double kBoxSigmas = 2;
/// Points a plane is made of, at least: three leaves' worth.
constexpr double kLeastPoints = 10;
/// A plane is this many times wider than thick, in standard deviations.
constexpr double kFlat = 5;
/// Points this many standard deviations off a plane are not in it.
constexpr double kOffSigmas = 3;

struct Plane {
  Vec3 point, normal;
  double thickness;  // m, standard deviation
};

/// Merges the stuff around the object, by class.
std::map<ClassId, Belief> stuffAround(const LocalGraph& local, const LocalObject& object) {
  const Vec3 half = kBoxSigmas * object.belief.cov.diagonal().cwiseMax(0).cwiseSqrt() + Vec3::Constant(kAround);
  std::map<ClassId, Belief> around;
  for (const LocalObject& stuff : local.objects) {
    if (!stuff.stuff) {
      continue;
    }
    const Vec3 extent = 2 * kBoxSigmas * stuff.belief.cov.diagonal().cwiseMax(0).cwiseSqrt();
    if (((stuff.belief.mean - object.belief.mean).cwiseAbs().array() > (half + extent).array()).any()) {
      continue;
    }
    for (const LocalLeaf& leaf : stuff.leaves) {
      const Vec3 d = (stuff.T_body_object * leaf.mean - object.belief.mean).cwiseAbs();
      if ((d.array() <= half.array()).all()) {
        const Belief here = transform(stuff.T_body_object, leaf);
        const auto [found, is_new] = around.try_emplace(stuff.label, here);
        found->second = is_new ? here : merge(found->second, here);
      }
    }
  }
  return around;
}

/// Share of the object's points in the plane.
double shareIn(const Plane& plane, const LocalObject& object) {
  double in = 0, all = 0;
  for (const LocalLeaf& leaf : object.leaves) {
    const Belief here = transform(object.T_body_object, leaf);
    const double off = plane.normal.dot(here.mean - plane.point);
    const double spread = std::sqrt(std::max(0.0, plane.normal.dot(here.cov * plane.normal)));
    all += leaf.kappa;
    in += std::hypot(off, spread) <= kOffSigmas * plane.thickness ? leaf.kappa : 0;
  }
  return all > 0 ? in / all : 0;
}

}  // namespace

ClassWeights viewsOfPlane(const LocalGraph& local, const LocalObject& object, double sigma_floor) {
  ClassWeights views;
  for (const auto& [label, stuff] : stuffAround(local, object)) {
    const Eigen3 e = eigenSymmetric(stuff.cov);
    const double thickness = std::hypot(std::sqrt(std::max(0.0, e.values[0])), sigma_floor);
    if (stuff.kappa < kLeastPoints || std::sqrt(std::max(0.0, e.values[1])) < kFlat * thickness) {
      continue;
    }
    if (const double share = shareIn({stuff.mean, e.vectors.col(0), thickness}, object); share > 0) {
      addWeight(views, label, kStretchOfWrongLabels * share);
    }
  }
  return views;
}

}  // namespace hgg
