#include "correction/pose_window.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace hgg {
namespace {

constexpr std::size_t kWindowSize = 10;  // keyframes: M of eq. fgo
/// Standard deviation in the map of a pose that leaves of the map have aligned, as a share of the leaf size and in rad.
/// No centroid of an object is observed as well: with looser poses, centroids moved them by 7 cm.
constexpr double kAlignedShare = 0.0125, kAlignedTurn = 2e-4;

/// Least standard deviations of a constraint: those of a robot at rest are so small that the normal equations would be
/// singular in all other directions. m, rad.
constexpr double kSharpest = 1e-3, kSharpestTurn = 1e-4;

BetweenConstraint bounded(BetweenConstraint constraint) {
  constraint.sigma = std::max(constraint.sigma, kSharpest);
  constraint.sigma_turn = std::max(constraint.sigma_turn, kSharpestTurn);
  return constraint;
}

/// Adds the constraints that have both ends in the window.
void addConstraints(const std::vector<BetweenConstraint>& constraints, const std::map<KeyframeId, int>& index_of,
                    WindowProblem& problem) {
  for (BetweenConstraint e : constraints) {
    const auto a = index_of.find(e.a), b = index_of.find(e.b);
    if (a != index_of.end() && b != index_of.end()) {
      e.a = a->second, e.b = b->second;
      problem.constraints.push_back(bounded(e));
    }
  }
}

}  // namespace

void PoseWindow::add(const Map& map, KeyframeId keyframe, const LocalGraph& local, const Alignment& alignment) {
  Keyframe added{keyframe, alignment.leaf_pairs > 0, {}, map.keyframes().edgesOf(keyframe)};
  std::erase_if(added.constraints, [&](const BetweenConstraint& e) { return e.b != keyframe; });
  for (const ObjectPair& pair : alignment.pairs) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    const MapNode* node = map.find(pair.map);
    if (object.stuff || node == nullptr) {
      continue;
    }
    added.seen_body.emplace_back(pair.map, object.belief);
    Belief before = transform(node->T_map_object.inverse(), node->belief);
    // Nothing was known before of an object made since the last keyframe; of any other all but this frame's evidence.
    before.kappa = node->anchor >= std::max(keyframe - 1, 0) ? 0 : std::max(0.0, before.kappa - object.belief.kappa);
    before_.try_emplace(pair.map, before);
  }
  keyframes_.push_back(std::move(added));
  if (keyframes_.size() > kWindowSize) {
    moveToPrior(map, keyframes_.front());
    keyframes_.pop_front();
  }
}

void PoseWindow::moveToPrior(const Map& map, const Keyframe& keyframe) {
  const Pose& T_map_body = map.keyframes().poses()[static_cast<std::size_t>(keyframe.id)].T_map_body;
  for (const auto& [id, belief_body] : keyframe.seen_body) {
    const MapNode* node = map.find(id);
    if (node == nullptr) {
      continue;
    }
    Belief& before = before_.at(id);
    before = merge(before, transform(node->T_map_object.inverse() * T_map_body, belief_body));
  }
  std::erase_if(before_, [&](const auto& entry) {
    return std::none_of(std::next(keyframes_.begin()), keyframes_.end(), [&](const Keyframe& k) {
      return std::ranges::any_of(k.seen_body, [&](const auto& seen) { return seen.first == entry.first; });
    });
  });
}

WindowProblem PoseWindow::problemOf(const Map& map, double leaf_size) const {
  WindowProblem problem;
  std::map<KeyframeId, int> index_of;
  std::map<NodeId, int> object_of;
  for (const Keyframe& keyframe : keyframes_) {
    const auto pose = static_cast<int>(problem.poses.size());
    index_of[keyframe.id] = pose;
    problem.poses.push_back(map.keyframes().poses()[static_cast<std::size_t>(keyframe.id)].T_map_body);
    for (const auto& [id, belief_body] : keyframe.seen_body) {
      const MapNode* node = map.find(id);
      if (node == nullptr) {
        continue;
      }
      const auto [object, is_new] = object_of.try_emplace(id, static_cast<int>(problem.objects.size()));
      if (is_new) {
        problem.objects.push_back(transform(node->T_map_object, before_.at(id)));
      }
      problem.observations.push_back({pose, object->second, belief_body});
    }
  }
  BetweenConstraint aligned = bounded({0, 0, Pose::Identity(), kAlignedShare * leaf_size, kAlignedTurn, false});
  problem.oldest = {problem.poses.front(), informationOf(aligned)};
  for (std::size_t k = 1; k < keyframes_.size(); ++k) {
    if (keyframes_[k].is_aligned) {
      aligned.b = static_cast<KeyframeId>(k);
      aligned.T_a_b = problem.poses.front().inverse() * problem.poses[k];
      problem.constraints.push_back(aligned);
    }
  }
  for (const Keyframe& keyframe : keyframes_) {
    addConstraints(keyframe.constraints, index_of, problem);
  }
  return problem;
}

std::optional<MapCorrection> PoseWindow::solve(const Map& map, double leaf_size, const WindowConfig& config) const {
  if (keyframes_.size() < 2 || keyframes_.back().is_aligned) {
    return std::nullopt;
  }
  const WindowSolution solution = solveWindow(problemOf(map, leaf_size), config);
  if (!solution.usable || solution.cost_after >= solution.cost_before) {
    return std::nullopt;
  }
  MapCorrection correction;
  correction.is_measured = true;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    correction.moved.emplace_back(keyframes_[k].id, solution.poses[k]);
  }
  return correction;
}

}  // namespace hgg
