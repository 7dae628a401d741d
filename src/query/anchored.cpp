#include "query/anchored.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "query/relations.h"

namespace hgg {
namespace {

const SceneThing& thingAt(const QueryScene& scene, int k) { return scene.things[static_cast<std::size_t>(k)]; }

bool hasDirection(Relation relation) {
  return relation == Relation::kFront || relation == Relation::kBehind || relation == Relation::kLeft ||
         relation == Relation::kRight || relation == Relation::kAcross;
}

double likelihoodInDirection(Relation relation, const SceneThing& thing, const SceneThing& anchor,
                             const std::vector<Gaze>& directions) {
  double sum = 0;
  for (const Gaze& d : directions) {
    sum += d.probability * (relation == Relation::kAcross ? likelihoodTowards(thing, anchor, d.direction)
                                                          : likelihoodBeside(thing, anchor, d.direction));
  }
  return sum;
}

double likelihoodOf(Relation relation, const SceneThing& thing, const SceneThing& anchor,
                    const std::vector<Gaze>& directions) {
  switch (relation) {
    case Relation::kOn:
      return likelihoodOn(thing, anchor);
    case Relation::kSupporting:
      return likelihoodOn(anchor, thing);
    case Relation::kAbove:
      return likelihoodAbove(thing, anchor);
    case Relation::kBelow:
      return likelihoodBelow(thing, anchor);
    case Relation::kInside:
      return likelihoodInside(thing, anchor);
    case Relation::kWith:
      return likelihoodWith(thing, anchor);
    default:
      return hasDirection(relation) ? likelihoodInDirection(relation, thing, anchor, directions)
                                    : likelihoodNear(thing, anchor);
  }
}

/// Nearness by rank alone, as NearnessRule says: neighbours in the graph come before all others.
std::vector<double> likelihoodsByOrder(const QueryScene& scene, const Peers& peers, const SceneThing& anchor) {
  constexpr double kPerRank = 1.6;  // nats, as for "second" (docs/language.md)
  std::vector<std::pair<bool, double>> places;
  for (const int k : peers.things) {
    const auto edge = anchor.edges.find(k);
    const bool is_gated = scene.nearness == NearnessRule::kEdges && edge != anchor.edges.end();
    places.emplace_back(!is_gated, is_gated ? edge->second : (thingAt(scene, k).centre - anchor.centre).norm());
  }
  std::vector<double> likelihoods;
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::ptrdiff_t rank = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const bool counts = peers.is_peer[k] && thingAt(scene, peers.things[k]).id != anchor.id;
      rank += counts && places[k] < places[i] ? 1 : 0;
    }
    likelihoods.push_back(std::exp(-kPerRank * static_cast<double>(rank)));
  }
  return likelihoods;
}

/// The least and the greatest distance of a peer to an anchor, the anchor itself left out.
std::pair<double, double> rangeOfPeers(const QueryScene& scene, const Peers& peers, const SceneThing& anchor) {
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t i = 0; i < peers.things.size(); ++i) {
    const SceneThing& thing = thingAt(scene, peers.things[i]);
    if (peers.is_peer[i] && thing.id != anchor.id) {
      const double d = nearDistance(thing, anchor);
      range = {std::min(range.first, d), std::max(range.second, d)};
    }
  }
  return range.second > 0 ? range : std::pair(0.0, range.second);
}

}  // namespace

std::vector<double> likelihoodsToOne(const QueryScene& scene, Relation relation, const Peers& peers,
                                     const SceneThing& anchor, const std::vector<Gaze>& directions) {
  const bool is_nearness = relation == Relation::kNear || relation == Relation::kClosest;
  if (is_nearness && scene.nearness != NearnessRule::kSurfaces) {
    return likelihoodsByOrder(scene, peers, anchor);
  }
  const bool compares = relation == Relation::kClosest || relation == Relation::kFar;
  const auto [nearest, farthest] = compares ? rangeOfPeers(scene, peers, anchor) : std::pair(0.0, 0.0);
  std::vector<double> likelihoods;
  for (const int k : peers.things) {
    const SceneThing& thing = thingAt(scene, k);
    likelihoods.push_back(relation == Relation::kClosest ? likelihoodClosest(thing, anchor, nearest)
                          : relation == Relation::kFar   ? likelihoodFar(thing, anchor, farthest)
                                                         : likelihoodOf(relation, thing, anchor, directions));
  }
  return likelihoods;
}

std::vector<double> likelihoodsTo(const QueryScene& scene, Relation relation, const Peers& peers,
                                  const Referents& anchors, bool is_settled, const DirectionsAt& directions_at) {
  const std::span<const int> things = peers.things;
  std::map<ClassId, std::pair<double, std::vector<double>>> of_class;  // the anchor's: its probability, and the sum
  for (const Referent& r : anchors) {
    const SceneThing& anchor = thingAt(scene, r.thing);
    auto& [probability, sum] = of_class[anchor.label];
    sum.resize(things.size());
    probability += r.probability;
    const std::vector<Gaze> directions = hasDirection(relation) ? directions_at(anchor) : std::vector<Gaze>{};
    std::vector<double> to_one = likelihoodsToOne(scene, relation, peers, anchor, directions);
    double most = 0;
    for (std::size_t i = 0; i < things.size(); ++i) {
      to_one[i] = things[i] != r.thing ? to_one[i] : 0;
      most = std::max(most, to_one[i]);
    }
    const double weight = is_settled && most > 0 ? r.probability / most : r.probability;
    for (std::size_t i = 0; i < things.size(); ++i) {
      sum[i] += weight * to_one[i];
    }
  }
  std::vector<double> all(things.size(), 0.0);
  for (const auto& [label, of] : of_class) {
    const double most = of.second.empty() ? 0 : std::ranges::max(of.second);
    for (std::size_t i = 0; most > 0 && i < all.size(); ++i) {
      all[i] += of.second[i] * of.first / most;
    }
  }
  return all;
}

std::vector<double> likelihoodsFarFrom(const QueryScene& scene, const Peers& peers, const Referents& anchors) {
  std::vector<double> log_sum(peers.things.size(), 0.0);
  double all = 0;
  for (const Referent& r : anchors) {
    const std::vector<double> to_one = likelihoodsToOne(scene, Relation::kFar, peers, thingAt(scene, r.thing), {});
    for (std::size_t i = 0; i < log_sum.size(); ++i) {
      log_sum[i] += r.probability * std::log(std::max(to_one[i], 1e-300));
    }
    all += r.probability;
  }
  for (double& v : log_sum) {
    v = std::exp(v / std::max(all, 1e-9));
  }
  return log_sum;
}

std::vector<double> likelihoodsBetween(const QueryScene& scene, std::span<const int> things, const Referents& a,
                                       const Referents& b, bool is_pair) {
  std::vector<double> sum(things.size(), 1e-6);
  constexpr std::size_t kMost = 12;  // anchors on each side: a hall of chairs has too many pairs
  for (std::size_t i = 0; i < std::min(a.size(), kMost); ++i) {
    for (std::size_t j = is_pair ? 0 : i + 1; j < std::min(b.size(), kMost); ++j) {
      if (a[i].thing == b[j].thing) {
        continue;
      }
      const SceneThing &from = thingAt(scene, a[i].thing), &to = thingAt(scene, b[j].thing);
      // Of many pairs, one that stands close is meant.
      const double p = a[i].probability * b[j].probability / (1 + gapBetween(from, to));
      for (std::size_t k = 0; k < sum.size(); ++k) {
        if (things[k] != a[i].thing && things[k] != b[j].thing) {
          sum[k] += p * likelihoodBetween(thingAt(scene, things[k]), from, to);
        }
      }
    }
  }
  return sum;
}

}  // namespace hgg
