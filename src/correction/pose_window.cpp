#include "correction/pose_window.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace hgg {
namespace {

constexpr std::size_t kViews = 10;  // keyframes: M of eq. fgo
/// A pose that the leaves of the map hold is known in it to a part of their size, which no mean of a view comes near:
/// centroids of views moved such poses by 7 cm.
constexpr double kHeldShare = 0.0125, kHeldTurn = 2e-4;  // of the leaf size; rad

/// What is known better is not told apart: a robot at rest would make the normal equations singular beside it.
constexpr double kSharpest = 1e-3, kSharpestTurn = 1e-4;  // m, rad

Mat6 informationOf(double sigma, double sigma_turn) {
  sigma = std::max(sigma, kSharpest), sigma_turn = std::max(sigma_turn, kSharpestTurn);
  Mat6 information = Mat6::Zero();
  information.diagonal() << Vec3::Constant(1 / (sigma * sigma)), Vec3::Constant(1 / (sigma_turn * sigma_turn));
  return information;
}

/// The constraints that lie within the window.
void addMotions(const std::vector<BetweenConstraint>& constraints, const std::map<KeyframeId, int>& index_of,
                WindowProblem& problem) {
  for (const BetweenConstraint& e : constraints) {
    const auto a = index_of.find(e.a), b = index_of.find(e.b);
    if (a != index_of.end() && b != index_of.end()) {
      problem.motions.push_back({a->second, b->second, e.T_a_b, informationOf(e.sigma, e.sigma_turn)});
    }
  }
}

}  // namespace

void PoseWindow::add(const Map& map, KeyframeId keyframe, const LocalGraph& local, const Alignment& alignment) {
  View view{keyframe, alignment.leaf_pairs > 0, {}, map.keyframes().edgesOf(keyframe)};
  std::erase_if(view.constraints, [&](const BetweenConstraint& e) { return e.b != keyframe; });
  for (const ObjectPair& pair : alignment.pairs) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    const MapNode* node = map.find(pair.map);
    if (object.stuff || node == nullptr) {
      continue;
    }
    view.seen_body.emplace_back(pair.map, object.belief);
    Belief before = transform(node->T_map_object.inverse(), node->belief);
    // One that was made since the last keyframe was not known before; of another this frame's share is.
    before.kappa = node->anchor >= std::max(keyframe - 1, 0) ? 0 : std::max(0.0, before.kappa - object.belief.kappa);
    before_.try_emplace(pair.map, before);
  }
  views_.push_back(std::move(view));
  if (views_.size() > kViews) {
    leaveBehind(map, views_.front());
    views_.pop_front();
  }
}

void PoseWindow::leaveBehind(const Map& map, const View& view) {
  const Pose& T_map_body = map.keyframes().poses()[static_cast<std::size_t>(view.keyframe)].T_map_body;
  for (const auto& [id, belief_body] : view.seen_body) {
    const MapNode* node = map.find(id);
    if (node == nullptr) {
      continue;
    }
    Belief& before = before_.at(id);
    before = merge(before, transform(node->T_map_object.inverse() * T_map_body, belief_body));
  }
  std::erase_if(before_, [&](const auto& entry) {
    return std::none_of(std::next(views_.begin()), views_.end(), [&](const View& v) {
      return std::ranges::any_of(v.seen_body, [&](const auto& seen) { return seen.first == entry.first; });
    });
  });
}

WindowProblem PoseWindow::problemOf(const Map& map, const Config& config) const {
  WindowProblem problem;
  std::map<KeyframeId, int> index_of;
  std::map<NodeId, int> object_of;
  for (const View& view : views_) {
    const auto pose = static_cast<int>(problem.poses.size());
    index_of[view.keyframe] = pose;
    problem.poses.push_back(map.keyframes().poses()[static_cast<std::size_t>(view.keyframe)].T_map_body);
    for (const auto& [id, belief_body] : view.seen_body) {
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
  const Mat6 held = informationOf(kHeldShare * config.map.leaf_size, kHeldTurn);
  problem.oldest = {problem.poses.front(), held};
  for (std::size_t k = 1; k < views_.size(); ++k) {
    if (views_[k].is_held) {
      problem.motions.push_back({0, static_cast<int>(k), problem.poses.front().inverse() * problem.poses[k], held});
    }
  }
  for (const View& view : views_) {
    addMotions(view.constraints, index_of, problem);
  }
  return problem;
}

std::optional<MapCorrection> PoseWindow::solve(const Map& map, const Config& config) const {
  if (views_.size() < 2 || views_.back().is_held) {
    return std::nullopt;
  }
  WindowConfig window;
  window.sigma_floor = config.creation.sigma_floor;
  window.noise.uniform_weights = config.ablation.uniform_weights;
  const WindowSolution solution = solveWindow(problemOf(map, config), window);
  if (!solution.usable || solution.cost_after >= solution.cost_before) {
    return std::nullopt;
  }
  MapCorrection correction;
  correction.is_measured = true;
  for (std::size_t k = 0; k < views_.size(); ++k) {
    correction.moved.emplace_back(views_[k].keyframe, solution.poses[k]);
  }
  return correction;
}

}  // namespace hgg
