#include "map/keyframes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr double kKeyframeDistance = 2.0;  // m
constexpr double kKeyframeAngle = 20 * kDegree;
constexpr double kLoosestShare = 0.1;  // of what makes a constraint say nothing

}  // namespace

bool KeyframeGraph::needsOne(const Pose& T_map_body) const { return poses_.empty() || !isAt(current_, T_map_body); }

bool KeyframeGraph::isAt(KeyframeId id, const Pose& T_map_body) const {
  const Pose step = poses_[static_cast<std::size_t>(id)].T_map_body.inverse() * T_map_body;
  return step.translation().norm() < kKeyframeDistance && turnOf(step) < kKeyframeAngle;
}

KeyframeId KeyframeGraph::newestAt(const Vec3& p_map) const {
  const auto distance = [&](const TimedPose& k) { return (k.T_map_body.translation() - p_map).norm(); };
  double nearest = std::numeric_limits<double>::infinity();
  for (const TimedPose& k : poses_) {
    nearest = std::min(nearest, distance(k));
  }
  KeyframeId id = last();
  while (id >= 0 && !(distance(poses_[static_cast<std::size_t>(id)]) <= nearest + kKeyframeDistance)) {
    --id;
  }
  return id;
}

KeyframeId KeyframeGraph::add(const TimedPose& pose) {
  poses_.push_back(pose);
  edges_of_.emplace_back();
  current_ = last();
  return current_;
}

void KeyframeGraph::connect(const BetweenConstraint& edge) {
  const auto index = static_cast<std::uint32_t>(edges_.size());
  BetweenConstraint& added = edges_.emplace_back(edge);
  added.expected = added.expected < 0 ? added.sigma : added.expected;
  added.expected_turn = added.expected_turn < 0 ? added.sigma_turn : added.expected_turn;
  edges_of_.at(static_cast<std::size_t>(edge.a)).push_back(index);
  edges_of_.at(static_cast<std::size_t>(edge.b)).push_back(index);
}

std::vector<BetweenConstraint> KeyframeGraph::edgesOf(KeyframeId id) const {
  std::vector<BetweenConstraint> edges;
  for (const std::uint32_t index : edges_of_.at(static_cast<std::size_t>(id))) {
    edges.push_back(edges_[index]);
  }
  return edges;
}

void KeyframeGraph::remeasure(const KeyframeMoves& moves) {
  const auto pose = [&](KeyframeId id) { return poses_[static_cast<std::size_t>(id)].T_map_body; };
  const auto isMoved = [&](KeyframeId id) {
    return std::ranges::binary_search(moves, id, {}, [](const auto& m) { return m.first; });
  };
  for (const auto& [id, move] : moves) {
    for (const std::uint32_t index : edges_of_.at(static_cast<std::size_t>(id))) {
      BetweenConstraint& e = edges_[index];
      if (e.b == id && !e.is_loop && isMoved(e.a)) {
        e.T_a_b = orthonormalized(pose(e.a).inverse() * pose(e.b));
      }
    }
  }
}

std::vector<KeyframeId> KeyframeGraph::fragments() const {
  std::vector<KeyframeId> oldest(poses_.size());
  std::iota(oldest.begin(), oldest.end(), 0);
  const auto find = [&oldest](KeyframeId k) {
    while (oldest[static_cast<std::size_t>(k)] != k) {
      KeyframeId& parent = oldest[static_cast<std::size_t>(k)];
      k = parent = oldest[static_cast<std::size_t>(parent)];
    }
    return k;
  };
  for (const BetweenConstraint& e : edges_) {
    if (!isLoose(e)) {
      const auto [low, high] = std::minmax({find(e.a), find(e.b)});
      oldest[static_cast<std::size_t>(high)] = low;
    }
  }
  for (KeyframeId& k : oldest) {
    k = find(k);
  }
  return oldest;
}

void KeyframeGraph::loosen(const Loosening& loosening) {
  const auto isBetween = [&](KeyframeId id) { return loosening.from <= id && id <= loosening.to; };
  for (BetweenConstraint& e : edges_) {
    if (!e.is_loop && !isLoose(e) && isBetween(e.a) && isBetween(e.b)) {
      const double factor = std::min(loosening.factor, kLoosestShare * kAnywhere / e.sigma);  // still not loose
      e.sigma *= factor, e.sigma_turn *= factor;
      e.expected *= factor, e.expected_turn *= factor;
    }
  }
}

namespace {

/// Calls settle(keyframe, drift) for each keyframe within `reach`, nearest first, until it returns false; `isSettled`
/// says of which it has been called.
template <typename Settle, typename IsSettled>
void spreadDrift(const KeyframeGraph& graph, KeyframeId from, double reach, Settle settle, IsSettled isSettled) {
  using Entry = std::tuple<double, double, KeyframeId>;  // position, turn, keyframe: ties in a fixed order
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(0.0, 0.0, from);
  while (!queue.empty()) {
    const double position = std::get<0>(queue.top()), turn = std::get<1>(queue.top());
    const KeyframeId k = std::get<2>(queue.top());
    queue.pop();
    if (isSettled(k)) {
      continue;
    }
    if (!settle(k, Drift{position, turn})) {
      return;
    }
    graph.forEachEdgeOf(k, [&](const BetweenConstraint& e) {
      const KeyframeId other = e.a == k ? e.b : e.a;
      const double beyond = std::hypot(position + turn * e.T_a_b.translation().norm(), e.sigma);
      if (beyond < reach && !isSettled(other)) {
        queue.emplace(beyond, std::hypot(turn, e.sigma_turn), other);
      }
    });
  }
}

}  // namespace

std::vector<Drift> KeyframeGraph::driftFrom(KeyframeId from, double reach) const {
  std::vector<Drift> drift(poses_.size(), Drift{-1, 0});
  spreadDrift(
      *this, from, reach,
      [&](KeyframeId k, const Drift& known) {
        drift[static_cast<std::size_t>(k)] = known;
        return true;
      },
      [&](KeyframeId k) { return drift[static_cast<std::size_t>(k)].position >= 0; });
  return drift;
}

Drift KeyframeGraph::driftFromTo(KeyframeId from, KeyframeId to) const {
  std::map<KeyframeId, Drift> settled;
  spreadDrift(
      *this, from, std::numeric_limits<double>::infinity(),
      [&](KeyframeId k, const Drift& known) {
        settled[k] = known;
        return k != to;
      },
      [&](KeyframeId k) { return settled.contains(k); });
  const auto found = settled.find(to);
  return found == settled.end() ? Drift{-1, 0} : found->second;
}

}  // namespace hgg
