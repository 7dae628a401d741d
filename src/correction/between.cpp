#include "correction/between.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

/// The motion from one keyframe to the next (map/keyframes).
constexpr double kStep = 2, kStepTurn = 20 * kDegree;  // m, rad
/// Alignment's error over one such step, as a share of the leaf size and in rad: 0.35 leaf sizes and 0.3 degrees in 100
/// m of street.
constexpr double kLossShare = 0.05, kTurnLoss = 0.04 * kDegree;
/// How well a frame lies on the part of the map it was aligned with, as a share of the leaf size and in rad.
constexpr double kFitShare = 0.125, kFitTurn = 0.2 * kDegree;
/// Uncertainty of the pose after a jump (startPose()): m, rad.
constexpr double kLost = 0.3, kLostTurn = 3 * kDegree;
constexpr std::size_t kMostAnchors = 2;
constexpr double kAnchorShare = 0.1;  // least share of the aligned leaves that makes an anchor count

/// The parts of a pose that the map does not constrain.
struct Unconstrained {
  bool position = false, turn = false;
};

Unconstrained unconstrainedBy(const Alignment& alignment) {
  Unconstrained unconstrained{alignment.leaf_pairs == 0, alignment.leaf_pairs == 0};
  for (const Vec6& direction : alignment.degenerate_directions) {  // of unit length
    unconstrained.position |= direction.head<3>().norm() > 0.5;
    unconstrained.turn |= direction.tail<3>().norm() > 0.5;
  }
  return unconstrained;
}

KeyframeId nearestActive(const Map& map, const Vec3& p_map) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  KeyframeId nearest = map.keyframes().last();
  for (KeyframeId k = nearest; k >= 0; --k) {
    const auto distanceOf = [&](KeyframeId id) {
      return (poses[static_cast<std::size_t>(id)].T_map_body.translation() - p_map).norm();
    };
    nearest = map.isActive(k) && distanceOf(k) < distanceOf(nearest) ? k : nearest;
  }
  return nearest;
}

/// The keyframes to which most leaves are anchored that the frame was aligned with, by falling number; `except` is left
/// out.
std::vector<KeyframeId> anchorsOf(const Map& map, const LocalGraph& local, const Alignment& alignment,
                                  KeyframeId except) {
  std::map<KeyframeId, double> leaves_of;
  double leaves = 0;
  for (const ObjectPair& pair : alignment.pairs) {
    const auto count = static_cast<double>(local.objects[static_cast<std::size_t>(pair.local)].leaves.size());
    leaves_of[map.find(pair.map)->anchor] += count;
    leaves += count;
  }
  std::vector<std::pair<double, KeyframeId>> ranked;
  for (const auto& [anchor, count] : leaves_of) {
    if (anchor >= 0 && anchor != except && count >= kAnchorShare * leaves) {
      ranked.emplace_back(-count, anchor);
    }
  }
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(std::min(ranked.size(), kMostAnchors));
  std::vector<KeyframeId> anchors;
  for (const auto& [count, anchor] : ranked) {
    anchors.push_back(anchor);
  }
  return anchors;
}

}  // namespace

Travel propagateTravel(const Travel& travel, const Pose& T_last_body, const Alignment& alignment, bool is_jump,
                       const AlignmentConfig& odometry, double leaf_size) {
  if (is_jump) {
    return {std::hypot(travel.sigma, kLost), std::hypot(travel.sigma_turn, kLostTurn), true};
  }
  const double way = T_last_body.translation().norm(), turn = turnOf(T_last_body);
  const double steps = std::sqrt(way / kStep + turn / kStepTurn);
  const double by_odometry = odometry.odometry_drift * way;
  const double turn_by_odometry = odometry.odometry_turn_deg * kDegree * way + odometry.odometry_drift * turn;
  const Unconstrained unconstrained = unconstrainedBy(alignment);
  return {
      unconstrained.position ? travel.sigma + by_odometry : std::hypot(travel.sigma, steps * kLossShare * leaf_size),
      unconstrained.turn ? travel.sigma_turn + turn_by_odometry : std::hypot(travel.sigma_turn, steps * kTurnLoss),
      travel.jumped};
}

std::vector<BetweenConstraint> betweenConstraints(const Pose& T_map_body, const Map& map, const LocalGraph& local,
                                                  const Alignment& alignment, const Travel& travel, double leaf_size) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  if (poses.empty()) {
    return {};
  }
  const auto constraintTo = [&](KeyframeId k, double sigma, double sigma_turn) {
    const Pose T_k_body = poses[static_cast<std::size_t>(k)].T_map_body.inverse() * T_map_body;
    return BetweenConstraint{k, -1, T_k_body, std::max(sigma, 1e-4), std::max(sigma_turn, 1e-5), false};
  };
  const KeyframeId last = map.keyframes().last();
  std::vector<BetweenConstraint> constraints;
  if (!travel.jumped) {
    constraints.push_back(constraintTo(last, travel.sigma, travel.sigma_turn));
  }
  const Unconstrained unconstrained = unconstrainedBy(alignment);
  // A pose that the map constrains in part only has drifted from all of it, and not only over this step.
  const bool is_constrained = !unconstrained.position && !unconstrained.turn;
  if (alignment.leaf_pairs > 0 && (is_constrained || travel.jumped)) {
    const double sigma = unconstrained.position ? travel.sigma : kFitShare * leaf_size;
    const double sigma_turn = unconstrained.turn ? travel.sigma_turn : kFitTurn;
    for (const KeyframeId anchor : anchorsOf(map, local, alignment, travel.jumped ? -1 : last)) {
      constraints.push_back(constraintTo(anchor, sigma, sigma_turn));
    }
  }
  if (constraints.empty()) {
    constraints.push_back(constraintTo(nearestActive(map, T_map_body.translation()), travel.sigma, travel.sigma_turn));
  }
  return constraints;
}

}  // namespace hgg
