#include "correction/between.h"

#include <Eigen/Cholesky>
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

/// What is expected of an aligned way. A frame is laid on the map with the error that its alignment's information
/// tells; what it adds to the map has that error, and as far as the view is renewed on the way the map goes on from
/// there. The view is so many leaf sizes long (leaf sizes go with the range of a sensor: 10 m outdoors, 2.5 m indoors,
/// which is the mean distance of what is aligned), and so wide. Frames before and after share the error: a share of it
/// is taken. docs/experiments.md, "How well a keyframe is known", has the figures.
constexpr double kViewLeaves = 25, kViewTurn = 90 * kDegree;
constexpr double kFreshShare = 0.3;

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

/// Mean standard deviations per axis.
struct Deviations {
  double position = 0, turn = 0;  // m, rad
};

/// How well a frame lies on the map that it was aligned with.
Deviations fitOf(const Alignment& alignment) {
  const Eigen::LLT<Mat6> factor(alignment.pose.information);
  if (alignment.leaf_pairs == 0 || factor.info() != Eigen::Success) {
    return {};
  }
  const Mat6 cov = factor.solve(Mat6::Identity());
  return {std::sqrt(cov.diagonal().head<3>().mean()), std::sqrt(cov.diagonal().tail<3>().mean())};
}

/// Share of a pose's translations and of its turns that odometry alone tells: 0, 1/3, 2/3 or 1, or something in between
/// where directions are mixed.
Deviations unknownShares(const Alignment& alignment) {
  if (alignment.leaf_pairs == 0) {
    return {1, 1};
  }
  Deviations shares;
  for (const Vec6& direction : alignment.degenerate_directions) {
    shares.position += direction.head<3>().squaredNorm() / 3;
    shares.turn += direction.tail<3>().squaredNorm() / 3;
  }
  return {std::min(shares.position, 1.0), std::min(shares.turn, 1.0)};
}

KeyframeId nearestActive(const Map& map, const Vec3& p_map) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  KeyframeId nearest = map.keyframes().current();
  for (KeyframeId k = map.keyframes().last(); k >= 0; --k) {
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
  const Unconstrained unconstrained = unconstrainedBy(alignment);
  const Deviations fit = fitOf(alignment);
  if ((is_jump || travel.jumped) && !unconstrained.position && !unconstrained.turn) {
    // The map tells where the frame is in it, whatever the jump was.
    return {kFitShare * leaf_size, kFitTurn, true, fit.position, fit.turn};
  }
  if (is_jump) {
    return {std::hypot(travel.sigma, kLost), std::hypot(travel.sigma_turn, kLostTurn), true,
            std::hypot(travel.expected, kLost), std::hypot(travel.expected_turn, kLostTurn)};
  }
  const double way = T_last_body.translation().norm(), turn = turnOf(T_last_body);
  const double steps = std::sqrt(way / kStep + turn / kStepTurn);
  const double by_odometry = odometry.odometry_drift * way;
  const double turn_by_odometry = odometry.odometry_turn_deg * kDegree * way + odometry.odometry_drift * turn;
  const Deviations unknown = unknownShares(alignment);
  const double fresh = kFreshShare * std::sqrt(std::min(1.0, way / (kViewLeaves * leaf_size) + turn / kViewTurn));
  return {
      unconstrained.position ? travel.sigma + by_odometry : std::hypot(travel.sigma, steps * kLossShare * leaf_size),
      unconstrained.turn ? travel.sigma_turn + turn_by_odometry : std::hypot(travel.sigma_turn, steps * kTurnLoss),
      travel.jumped, std::hypot(travel.expected, fresh * fit.position, std::sqrt(unknown.position) * by_odometry),
      std::hypot(travel.expected_turn, fresh * fit.turn, std::sqrt(unknown.turn) * turn_by_odometry)};
}

std::vector<BetweenConstraint> betweenConstraints(const Pose& T_map_body, const Map& map, const LocalGraph& local,
                                                  const Alignment& alignment, const Travel& travel, double leaf_size) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  if (poses.empty()) {
    return {};
  }
  const auto constraintTo = [&](KeyframeId k, const Deviations& cautious, const Deviations& expected) {
    const Pose T_k_body = poses[static_cast<std::size_t>(k)].T_map_body.inverse() * T_map_body;
    return BetweenConstraint{k,
                             -1,
                             T_k_body,
                             std::max(cautious.position, 1e-4),
                             std::max(cautious.turn, 1e-5),
                             false,
                             std::max(expected.position, 1e-5),
                             std::max(expected.turn, 1e-6)};
  };
  const Deviations travelled{travel.sigma, travel.sigma_turn}, expected{travel.expected, travel.expected_turn};
  const KeyframeId last = map.keyframes().current();
  std::vector<BetweenConstraint> constraints;
  if (!travel.jumped) {
    constraints.push_back(constraintTo(last, travelled, expected));
  }
  const Unconstrained unconstrained = unconstrainedBy(alignment);
  // A pose that the map constrains in part only has drifted from all of it, and not only over this step.
  const bool is_constrained = !unconstrained.position && !unconstrained.turn;
  if (alignment.leaf_pairs > 0 && (is_constrained || travel.jumped)) {
    const Deviations fit = fitOf(alignment);
    const Deviations cautious{unconstrained.position ? travel.sigma : kFitShare * leaf_size,
                              unconstrained.turn ? travel.sigma_turn : kFitTurn};
    const Deviations on_map{unconstrained.position ? travel.expected : fit.position,
                            unconstrained.turn ? travel.expected_turn : fit.turn};
    for (const KeyframeId anchor : anchorsOf(map, local, alignment, travel.jumped ? -1 : last)) {
      constraints.push_back(constraintTo(anchor, cautious, on_map));
    }
  }
  if (constraints.empty()) {
    constraints.push_back(constraintTo(nearestActive(map, T_map_body.translation()), travelled, expected));
  }
  return constraints;
}

BetweenConstraint looseConstraint(const Map& map, const Pose& T_map_body) {
  const Pose T_last_body = map.keyframes().currentPose().T_map_body.inverse() * T_map_body;
  return {map.keyframes().current(), -1, T_last_body, kAnywhere, kAnyTurn, false};
}

}  // namespace hgg
