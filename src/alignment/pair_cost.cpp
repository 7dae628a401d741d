#include "alignment/pair_cost.h"

#include <Eigen/Geometry>

#include "core/spd.h"

namespace hgg {
namespace {

/// An evenly filled interval ends sqrt(3) standard deviations from its middle.
constexpr double kSquareHalfWidth = 3;  // variances

/// The axis-parallel box that has this extent when it is evenly filled.
Eigen::AlignedBox3d boxOf(const Belief& belief, double sigma_floor) {
  const Vec3 half = (kSquareHalfWidth * withFloor(belief.cov, sigma_floor).diagonal()).cwiseSqrt();
  return {Vec3(belief.mean - half), Vec3(belief.mean + half)};
}

double intersectionOverUnion(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  const Eigen::AlignedBox3d common = a.intersection(b);
  const double volume = common.isEmpty() ? 0 : common.volume();
  return volume / (a.volume() + b.volume() - volume);
}

}  // namespace

double pairCost(const Belief& seen, const Belief& known, PairCost kind, double sigma_floor, double apart) {
  if (kind == PairCost::kCentroid) {
    return (seen.mean - known.mean).norm();
  }
  if (kind == PairCost::kIou) {
    return apart * (1 - intersectionOverUnion(boxOf(seen, sigma_floor), boxOf(known, sigma_floor)));
  }
  return wasserstein2(seen, known);
}

}  // namespace hgg
