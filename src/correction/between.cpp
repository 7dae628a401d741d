#include "correction/between.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

/// A keyframe's worth of motion.
constexpr double kStep = 2, kStepTurn = 20 * kDegree;  // m, rad
/// What alignment loses in it, as a share of a leaf's size and in turn: 0.35 m and 0.3 degrees in 100 m of street.
constexpr double kLossShare = 0.05, kTurnLoss = 0.04 * kDegree;
/// How well a frame lies on what it was aligned with.
constexpr double kFitShare = 0.125, kFitTurn = 0.2 * kDegree;
constexpr double kLost = 0.3, kLostTurn = 3 * kDegree;  // after a jump
constexpr std::size_t kMostAnchors = 2;
constexpr double kAnchorShare = 0.1;  // of the leaves that were aligned

/// What of the pose the map does not hold.
struct Unheld {
  bool position = false, turn = false;
};

Unheld unheldOf(const Alignment& alignment) {
  Unheld unheld{alignment.leaf_pairs == 0, alignment.leaf_pairs == 0};
  for (const Vec6& direction : alignment.degenerate_directions) {  // of unit length
    unheld.position |= direction.head<3>().norm() > 0.5;
    unheld.turn |= direction.tail<3>().norm() > 0.5;
  }
  return unheld;
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

/// The keyframes that most leaves of what was aligned with are anchored to, but for `tied`; the most first.
std::vector<KeyframeId> anchorsOf(const Map& map, const LocalGraph& local, const Alignment& alignment,
                                  KeyframeId tied) {
  std::map<KeyframeId, double> leaves_of;
  double leaves = 0;
  for (const ObjectPair& pair : alignment.pairs) {
    const auto count = static_cast<double>(local.objects[static_cast<std::size_t>(pair.local)].leaves.size());
    leaves_of[map.find(pair.map)->anchor] += count;
    leaves += count;
  }
  std::vector<std::pair<double, KeyframeId>> ranked;
  for (const auto& [anchor, count] : leaves_of) {
    if (anchor >= 0 && anchor != tied && count >= kAnchorShare * leaves) {
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

Travel travelOn(const Travel& travel, const Pose& T_last_body, const Alignment& alignment, bool is_jump,
                const Config& config) {
  if (is_jump) {
    return {std::hypot(travel.sigma, kLost), std::hypot(travel.sigma_turn, kLostTurn), true};
  }
  const double way = T_last_body.translation().norm(), turn = turnOf(T_last_body);
  const double steps = std::sqrt(way / kStep + turn / kStepTurn);
  const AlignmentConfig& odometry = config.alignment;
  const double by_odometry = odometry.odometry_drift * way;
  const double turn_by_odometry = odometry.odometry_turn_deg * kDegree * way + odometry.odometry_drift * turn;
  const Unheld unheld = unheldOf(alignment);
  return {unheld.position ? travel.sigma + by_odometry
                          : std::hypot(travel.sigma, steps * kLossShare * config.map.leaf_size),
          unheld.turn ? travel.sigma_turn + turn_by_odometry : std::hypot(travel.sigma_turn, steps * kTurnLoss),
          travel.jumped};
}

std::vector<BetweenConstraint> betweenConstraints(const Pose& T_map_body, const Map& map, const LocalGraph& local,
                                                  const Alignment& alignment, const Travel& travel,
                                                  const Config& config) {
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
  const Unheld unheld = unheldOf(alignment);
  const bool is_held = !unheld.position && !unheld.turn;  // else it drifts from all of the map, not by this step only
  if (alignment.leaf_pairs > 0 && (is_held || travel.jumped)) {
    const double sigma = unheld.position ? travel.sigma : kFitShare * config.map.leaf_size;
    const double sigma_turn = unheld.turn ? travel.sigma_turn : kFitTurn;
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
