#include "alignment/pair_cost.h"

#include <Eigen/Geometry>

#include "core/spd.h"

namespace hgg {
namespace {

/// The axis-parallel box that holds an evenly spread Gaussian of this extent.
Eigen::AlignedBox3d boxOf(const Belief& belief, double sigma_floor) {
  const Vec3 half = (3 * withFloor(belief.cov, sigma_floor).diagonal()).cwiseSqrt();
  return {Vec3(belief.mean - half), Vec3(belief.mean + half)};
}

double intersectionOverUnion(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  const Eigen::AlignedBox3d common = a.intersection(b);
  const double volume = common.isEmpty() ? 0 : common.volume();
  return volume / (a.volume() + b.volume() - volume);
}

}  // namespace

double pairCost(const Belief& seen, const Belief& known, const Config& config) {
  if (config.ablation.cost == PairCost::kCentroid) {
    return (seen.mean - known.mean).norm();
  }
  if (config.ablation.cost == PairCost::kIou) {
    const double floor = config.creation.sigma_floor, share = config.alignment.geometry_share;
    const double apart = 1 - intersectionOverUnion(boxOf(seen, floor), boxOf(known, floor));
    return apart * config.alignment.gate / (share > 0 ? share : 1);
  }
  return wasserstein2(seen, known);
}

}  // namespace hgg
