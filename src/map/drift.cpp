#include "map/drift.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>

#include "core/units.h"

namespace hgg {
namespace {

Mat6 diagonalOf(double sigma, double sigma_turn) {
  Mat6 cov = Mat6::Zero();
  cov.diagonal() << Vec3::Constant(square(sigma)), Vec3::Constant(square(sigma_turn));
  return cov;
}

double positionVariance(const Mat6& cov) { return cov.topLeftCorner<3, 3>().trace(); }

/// The covariance at the other end of a constraint, given that at keyframe `from`. A constraint's own error is one of
/// b's origin, so going back from b to a it swings a.
Mat6 across(const KeyframeGraph& graph, const BetweenConstraint& e, KeyframeId from, const Mat6& cov) {
  const auto positionOf = [&](KeyframeId id) -> Vec3 {
    return graph.poses()[static_cast<std::size_t>(id)].T_map_body.translation();
  };
  const bool is_forward = e.a == from;
  const Mat6 F = tangentTransport(positionOf(is_forward ? e.b : e.a) - positionOf(from));
  const Mat6 own = diagonalOf(e.expected, e.expected_turn);
  return is_forward ? Mat6(F * cov * F.transpose() + own) : Mat6(F * (cov + own) * F.transpose());
}

/// Keyframes in the order in which their positions become known, best first. A turn back can make a position better
/// known than that of the keyframe before it on the path; its rank then is that of the one before.
std::vector<Mat6> spread(const KeyframeGraph& graph, KeyframeId from, KeyframeId newest, KeyframeId until) {
  const auto count = static_cast<std::size_t>(newest) + 1;
  std::vector<Mat6> covariances(count, diagonalOf(kNotConnected, kNotConnectedTurn));
  std::vector<double> rank(count, positionVariance(covariances[0]));
  std::vector<bool> is_settled(count);
  using Entry = std::tuple<double, KeyframeId>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  covariances[static_cast<std::size_t>(from)].setZero();
  rank[static_cast<std::size_t>(from)] = 0;
  queue.emplace(0.0, from);
  while (!queue.empty()) {
    const KeyframeId k = std::get<KeyframeId>(queue.top());
    queue.pop();
    const auto i = static_cast<std::size_t>(k);
    if (is_settled[i]) {
      continue;
    }
    is_settled[i] = true;
    if (k == until) {
      break;
    }
    graph.forEachEdgeOf(k, [&](const BetweenConstraint& e) {
      const KeyframeId other = e.a == k ? e.b : e.a;
      const auto o = static_cast<std::size_t>(other);
      if (other > newest || is_settled[o]) {
        return;
      }
      const Mat6 cov = across(graph, e, k, covariances[i]);
      const double of_path = std::max(rank[i], positionVariance(cov));
      if (of_path < rank[o]) {
        rank[o] = of_path;
        covariances[o] = cov;
        queue.emplace(of_path, other);
      }
    });
  }
  return covariances;
}

}  // namespace

std::vector<Mat6> covariancesFrom(const KeyframeGraph& graph, KeyframeId from, KeyframeId newest) {
  return spread(graph, from, newest < 0 ? graph.last() : newest, -1);
}

Mat6 covarianceBetween(const KeyframeGraph& graph, KeyframeId from, KeyframeId to) {
  return spread(graph, from, graph.last(), to)[static_cast<std::size_t>(to)];
}

void PoseCovariances::add(const KeyframeGraph& graph) {
  const auto k = static_cast<KeyframeId>(covariances_.size());
  Mat6 best = k == 0 ? Mat6(Mat6::Zero()) : diagonalOf(kNotConnected, kNotConnectedTurn);
  graph.forEachEdgeOf(k, [&](const BetweenConstraint& e) {
    const KeyframeId other = e.a == k ? e.b : e.a;
    if (other < k) {
      const Mat6 cov = across(graph, e, other, covariances_[static_cast<std::size_t>(other)]);
      best = positionVariance(cov) < positionVariance(best) ? cov : best;
    }
  });
  covariances_.push_back(best);
}

void PoseCovariances::recompute(const KeyframeGraph& graph) {
  KeyframeId newest_loop = -1;
  for (const BetweenConstraint& e : graph.edges()) {
    newest_loop = e.is_loop ? std::max({newest_loop, e.a, e.b}) : newest_loop;
  }
  covariances_ = newest_loop < 0 ? std::vector<Mat6>() : covariancesFrom(graph, 0, newest_loop);
  while (covariances_.size() < graph.poses().size()) {
    add(graph);
  }
}

Mat6 PoseCovariances::of(KeyframeId id) const {
  return id < 0 ? Mat6(Mat6::Zero()) : covariances_.at(static_cast<std::size_t>(id));
}

}  // namespace hgg
