#include "map/object_graph.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/relative_neighbors.h"

namespace hgg {
namespace {

constexpr std::size_t kPostponedARefresh = 200;  // nodes: 2.4 ms of a frame (bench FrameAfterALoop)
constexpr double kShortMove = 0.5;               // m; where it was and where it is are looked for at once
constexpr double kSameS1 = 1e-6;                 // relative; a rigid move changes an S1 by its rounding only
constexpr double kRounding = 1 + 1e-12;          // of the square root of an exact squared distance
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

using Neighbor = ObjectGraph::Neighbor;

std::vector<Neighbor>::iterator linkTo(std::vector<Neighbor>& neighbors, NodeId id) {
  return std::ranges::lower_bound(neighbors, id, {}, &Neighbor::id);
}

}  // namespace

void ObjectGraph::setModel(const EdgeModel& model) {
  *this = {};
  model_ = model;
}

void ObjectGraph::put(NodeId id, ClassId label, const Belief& belief) {
  if (!model_) {
    return;
  }
  int handle = index_.find(id);
  if (handle < 0) {
    handle = index_.insert(id, belief.mean);
    nodes_.resize(index_.handleLimit());
    node(handle).cov = belief.cov, node(handle).label = label;
    fresh_.push_back({id, Kind::kCame, belief.mean, round_});
    return;
  }
  change(handle, belief);
  Node& self = node(handle);
  if (self.label != label) {
    self.label = label;
    for (const Neighbor& n : self.neighbors) {
      linkTo(node(n.handle).neighbors, id)->label = label;
    }
  }
}

void ObjectGraph::move(NodeId id, const Belief& belief) {
  if (const int handle = index_.find(id); handle >= 0) {
    change(handle, belief);
  }
}

void ObjectGraph::change(int handle, const Belief& belief) {
  if (index_.position(handle) != belief.mean) {
    fresh_.push_back({index_.idOf(handle), Kind::kMoved, index_.position(handle), round_});
    index_.move(handle, belief.mean);
  } else if (node(handle).cov != belief.cov) {
    fresh_.push_back({index_.idOf(handle), Kind::kReshaped, belief.mean, round_});
  }
  node(handle).cov = belief.cov;
}

void ObjectGraph::remove(NodeId id) {
  const int handle = index_.find(id);
  if (handle < 0) {
    return;
  }
  fresh_.push_back({id, Kind::kWent, index_.position(handle), round_});
  while (!node(handle).neighbors.empty()) {
    unlink(handle, node(handle).neighbors.back().handle);
  }
  index_.remove(handle);
  node(handle) = {};
}

std::vector<NodeId> ObjectGraph::refresh(Postponed postponed) {
  const std::size_t quota = postponed == Postponed::kTakeSome ? kPostponedARefresh : 0;
  for (std::size_t due = std::min(postponed_.size(), quota); due > 0; --due) {
    fresh_.push_back(postponed_.back());
    postponed_.pop_back();
    if (const int handle = index_.find(fresh_.back().id); handle >= 0 && node(handle).postponed > 0) {
      --node(handle).postponed;
    }
  }
  takeIn(std::exchange(fresh_, {}));
  std::vector<NodeId> rewired = std::exchange(rewired_, {});
  std::ranges::sort(rewired);
  rewired.erase(std::unique(rewired.begin(), rewired.end()), rewired.end());
  std::erase_if(rewired, [&](NodeId id) { return index_.find(id) < 0; });
  return rewired;
}

void ObjectGraph::postpone(const Vec3& first) {
  // A node that only changed its shape keeps its neighbours: it is not computed anew later, so it may not be left alone
  // until then. Its edges are measured at the next refresh.
  const auto moved =
      std::stable_partition(fresh_.begin(), fresh_.end(), [](const Change& c) { return c.kind == Kind::kReshaped; });
  for (auto change = moved; change != fresh_.end(); ++change) {
    postponed_.push_back(*change);
    if (const int handle = index_.find(change->id); handle >= 0) {
      ++node(handle).postponed;
    }
  }
  fresh_.erase(moved, fresh_.end());
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(postponed_.size());
  for (std::size_t k = 0; k < postponed_.size(); ++k) {
    order.emplace_back(-(postponed_[k].from - first).squaredNorm(), k);
  }
  std::ranges::sort(order);
  std::vector<Change> sorted;
  sorted.reserve(order.size());
  for (const auto& [nearness, k] : order) {
    sorted.push_back(postponed_[k]);
  }
  postponed_ = std::move(sorted);
}

void ObjectGraph::settle() {
  fresh_.insert(fresh_.end(), postponed_.begin(), postponed_.end());
  postponed_.clear();
  std::ranges::for_each(nodes_, [](Node& n) { n.postponed = 0; });
  if (fresh_.size() > size() / 2) {
    fresh_.clear();
    rebuild();
  } else {
    takeIn(std::exchange(fresh_, {}));
  }
  rewired_.clear();
}

/// As if all nodes had changed.
void ObjectGraph::rebuild() {
  ++round_;
  std::vector<int> all;
  for (int handle = 0; handle < static_cast<int>(nodes_.size()); ++handle) {
    if (index_.isUsed(handle)) {
      all.push_back(handle);
    }
  }
  std::ranges::for_each(all, [&](int handle) { compute(handle); });
  std::ranges::for_each(all, [&](int handle) { measure(handle, true); });
}

void ObjectGraph::takeIn(std::span<const Change> changes) {
  ++round_;
  marked_.clear();
  for (const Change& change : changes) {
    const int handle = index_.find(change.id);
    if (handle >= 0 && change.kind != Kind::kReshaped) {
      mark(handle);
    }
  }
  for (const Change& change : changes) {
    disturb(change);
  }
  for (const int handle : marked_) {
    compute(handle);
  }
  for (const Change& change : changes) {
    const int handle = index_.find(change.id);
    if (handle >= 0) {
      measure(handle, true);
    }
  }
  for (const int handle : marked_) {
    measure(handle, false);
  }
}

void ObjectGraph::mark(int handle) {
  if (node(handle).marked != round_) {
    node(handle).marked = round_;
    marked_.push_back(handle);
  }
}

/// Marks the nodes whose proof needed a changed node where it was, and cuts the edges it has come between.
void ObjectGraph::disturb(const Change& change) {
  if (change.kind == Kind::kReshaped) {
    return;
  }
  const bool was_there = change.kind != Kind::kCame;
  const int self = index_.find(change.id);
  const auto look = [&](int i) {
    const Node& other = node(i);
    if (other.marked == round_ || other.postponed > 0 || other.computed > change.round) {
      return;  // it is computed anew anyhow, or has been since
    }
    if (was_there && (change.from - index_.position(i)).squaredNorm() <= other.square_proof) {
      mark(i);
    } else if (self >= 0) {
      cutBlocked(i, self);
    }
  };
  const double moved = was_there && self >= 0 ? (index_.position(self) - change.from).norm() : 0;
  if (was_there && self >= 0 && moved <= kShortMove) {
    index_.reaching(change.from, moved * kRounding, look);
    return;
  }
  if (was_there) {
    index_.reaching(change.from, 0, look);
  }
  if (self >= 0) {
    index_.reaching(index_.position(self), 0, look);
  }
}

/// Cuts the edges of a node that another has come between.
void ObjectGraph::cutBlocked(int handle, int blocker) {
  const Vec3 p = index_.position(handle), p_k = index_.position(blocker);
  const double square_k = (p_k - p).squaredNorm();
  for (std::size_t n = node(handle).neighbors.size(); n > 0; --n) {
    const int other = node(handle).neighbors[n - 1].handle;
    const Vec3& p_j = index_.position(other);
    const double square = (p_j - p).squaredNorm();
    if (other != blocker && square_k < square && (p_k - p_j).squaredNorm() < square) {
      unlink(handle, other);
      node(handle).square_proof = std::max(node(handle).square_proof, square_k);
      index_.setReach(handle, std::max(index_.reachOf(handle), std::sqrt(square_k) * kRounding));
    }
  }
}

void ObjectGraph::unlink(int a, int b) {
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
    std::vector<Neighbor>& neighbors = node(from).neighbors;
    neighbors.erase(linkTo(neighbors, index_.idOf(to)));
    rewired_.push_back(index_.idOf(from));
    updateLargest(from);
  }
}

/// The neighbours of a node from scratch, here and in their lists. S1 of new edges is left to measure().
void ObjectGraph::compute(int handle) {
  ++computations_;
  const Vec3 p = index_.position(handle);
  const NodeId id = index_.idOf(handle);
  Node& self = node(handle);
  Blockers blockers(p);
  for (const Neighbor& n : self.neighbors) {
    blockers.add(index_.position(n.handle));
  }
  const auto isAsked = [&](int j) { return node(j).computed != round_; };
  self.square_proof = collectNeighbors(index_, p, handle, isAsked, blockers, found_);
  for (const Neighbor& n : self.neighbors) {
    if (!isAsked(n.handle)) {
      found_.push_back(n.handle);  // it has been computed, and is one
    }
  }
  self.computed = round_;
  std::ranges::sort(found_, {}, [&](int j) { return index_.idOf(j); });
  double square_reach = self.square_proof;
  for (const int j : found_) {
    square_reach = std::max(square_reach, (index_.position(j) - p).squaredNorm());
  }
  index_.setReach(handle, std::sqrt(square_reach) * kRounding);
  for (std::size_t n = self.neighbors.size(); n > 0; --n) {
    const int other = self.neighbors[n - 1].handle;
    if (!std::ranges::binary_search(found_, index_.idOf(other), {}, [&](int j) { return index_.idOf(j); })) {
      unlink(handle, other);
    }
  }
  for (const int j : found_) {
    const NodeId other = index_.idOf(j);
    const auto place = linkTo(self.neighbors, other);
    if (place != self.neighbors.end() && place->id == other) {
      continue;
    }
    self.neighbors.insert(place, {other, node(j).label, kUnknown, j});
    std::vector<Neighbor>& back = node(j).neighbors;
    back.insert(linkTo(back, id), {id, self.label, kUnknown, handle});
    rewired_.push_back(id);
    rewired_.push_back(other);
  }
}

/// S1 of the edges of a node: of all of them, or of those that are new.
void ObjectGraph::measure(int handle, bool anew) {
  Node& self = node(handle);
  if (self.measured == round_) {
    return;
  }
  self.measured = anew ? round_ : self.measured;
  const NodeId id = index_.idOf(handle);
  for (Neighbor& n : self.neighbors) {
    Node& other = node(n.handle);
    if (!std::isnan(n.s1) && (!anew || other.measured == round_)) {
      continue;
    }
    const auto [a, b] = id < n.id ? std::pair(handle, n.handle) : std::pair(n.handle, handle);
    const double s1 = edgeDistance(beliefOf(a), beliefOf(b), model_->sigma_floor);
    if (!(std::abs(s1 - n.s1) <= kSameS1 * std::abs(s1))) {
      rewired_.push_back(id);
      rewired_.push_back(n.id);
    }
    n.s1 = linkTo(other.neighbors, id)->s1 = s1;
    updateLargest(n.handle);
  }
  updateLargest(handle);
}

void ObjectGraph::updateLargest(int handle) {
  double largest = 0;
  for (const Neighbor& n : node(handle).neighbors) {
    largest = std::max(largest, n.s1);
  }
  largest_s1_.set(static_cast<std::size_t>(handle), largest);
}

std::span<const Neighbor> ObjectGraph::neighborsOf(NodeId id) const {
  const int handle = index_.find(id);
  return handle < 0 ? std::span<const Neighbor>() : node(handle).neighbors;
}

std::vector<Neighbor> ObjectGraph::neighborsAt(const Vec3& p) const {
  std::vector<int> handles;
  Blockers blockers(p);
  collectNeighbors(
      index_, p, -1, [](int) { return true; }, blockers, handles);
  std::vector<Neighbor> neighbors;
  for (const int j : handles) {
    neighbors.push_back({index_.idOf(j), node(j).label, 0, j});
  }
  std::ranges::sort(neighbors, {}, &Neighbor::id);
  return neighbors;
}

Edge ObjectGraph::edgeOf(NodeId id, const Node& of, const Neighbor& to) const {
  const double c = model_->geometry_share, s1_max = largest_s1_.largest(), s2 = of.label == to.label ? 0 : 1;
  const double weight = (s1_max > 0 ? c * to.s1 / s1_max : 0) + (1 - c) * s2;
  return {std::min(id, to.id), std::max(id, to.id), static_cast<float>(weight)};
}

std::vector<Edge> ObjectGraph::edgesOf(const std::vector<NodeId>& ids) const {
  std::vector<Edge> edges, downward;  // those to an older node come as its own if it is asked for too
  for (const NodeId id : ids) {
    const int handle = index_.find(id);
    if (handle < 0) {
      continue;
    }
    for (const Neighbor& n : node(handle).neighbors) {
      if (n.id > id) {
        edges.push_back(edgeOf(id, node(handle), n));
      } else if (!std::ranges::binary_search(ids, n.id)) {
        downward.push_back(edgeOf(id, node(handle), n));
      }
    }
  }
  const auto isBefore = [](const Edge& x, const Edge& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); };
  std::ranges::sort(downward, isBefore);
  const auto middle = edges.insert(edges.end(), downward.begin(), downward.end());
  std::inplace_merge(edges.begin(), middle, edges.end(), isBefore);
  return edges;
}

std::vector<Edge> ObjectGraph::edges() const {
  std::vector<NodeId> ids;
  for (int handle = 0; handle < static_cast<int>(nodes_.size()); ++handle) {
    if (index_.isUsed(handle)) {
      ids.push_back(index_.idOf(handle));
    }
  }
  std::ranges::sort(ids);
  return edgesOf(ids);
}

}  // namespace hgg
