#include "alignment/fit.h"

#include <cmath>

#include "core/spd.h"

namespace hgg {
namespace {

constexpr double kFits = 9;  // squared standard deviations: three of them
/// A leaf is level when it is flat (its thickness is less than half its next extent) and its normal is within 37
/// degrees of the vertical. Chosen by hand: slopes and kerbs are ground, steep roofs and walls are not.
constexpr double kFlat = 4, kLevelNormal = 0.8;
constexpr double kThinnest = 0.01;  // m, floor of a leaf's thickness

constexpr double kFewestKnown = 30;  // leaves: below, the map has too little there to tell
constexpr double kCollapsed = 0.5;   // of the usual share; on good drives it never fell below 0.55
constexpr double kLately = 0.1;      // weight of the newest frame in the usual share

bool isUprightAt(const Pose& T_map_object, const LocalLeaf& leaf) {
  return isUpright(T_map_object.linear() * leaf.cov * T_map_object.linear().transpose());
}

}  // namespace

bool isUpright(const Mat3& cov) {
  const Eigen3 e = eigenSymmetric(withFloor(cov, kThinnest));
  return e.values[0] * kFlat >= e.values[1] || std::abs(e.vectors(2, 0)) < kLevelNormal;
}

void UsualFit::learn(const Fit& fit) {
  if (canTell(fit)) {
    share_ = share_ == 0 ? fit.share() : share_ + kLately * (fit.share() - share_);
  }
}

bool UsualFit::canTell(const Fit& fit) { return fit.known >= kFewestKnown; }

bool UsualFit::hasCollapsed(const Fit& fit) const { return canTell(fit) && fit.share() < kCollapsed * share_; }

Fit fitOf(const LocalGraph& local, const std::vector<ObjectPair>& pairs, const std::vector<LeafPair>& leaf_pairs,
          std::span<const GaussianPair> gaussians, std::size_t stride, const Pose& T_map_body) {
  Fit fit;
  std::size_t leaf = 0;
  for (const ObjectPair& pair : pairs) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    const Pose T_map_object = T_map_body * object.T_body_object;
    for (std::size_t u = 0; u < object.leaves.size(); ++u, ++leaf) {
      fit.known +=
          leaf % stride == 0 && hasExtent(object.leaves[u]) && isUprightAt(T_map_object, object.leaves[u]) ? 1 : 0;
    }
  }
  for (std::size_t k = 0; k < leaf_pairs.size(); ++k) {
    const ObjectPair& pair = pairs[static_cast<std::size_t>(leaf_pairs[k].pair)];
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    const LocalLeaf& seen = object.leaves[static_cast<std::size_t>(leaf_pairs[k].local)];
    const bool fits = registrationCost(gaussians.subspan(k, 1), T_map_body) < kFits;
    fit.fitting += fits && isUprightAt(T_map_body * object.T_body_object, seen) ? 1 : 0;
  }
  return fit;
}

}  // namespace hgg
