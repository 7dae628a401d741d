#include "query/anchored.h"

#include <algorithm>
#include <cmath>
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

}  // namespace

double likelihoodOf(Relation relation, const SceneThing& thing, const SceneThing& anchor,
                    const std::vector<Gaze>& directions) {
  switch (relation) {
    case Relation::kClosest:
      return likelihoodClosest(thing, anchor);
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

std::vector<double> likelihoodsTo(const QueryScene& scene, Relation relation, const std::vector<int>& things,
                                  const Referents& anchors, const DirectionsAt& directions_at) {
  std::map<ClassId, std::pair<double, std::vector<double>>> of_class;  // the anchor's: its probability, and the sum
  for (const Referent& r : anchors) {
    const SceneThing& anchor = thingAt(scene, r.thing);
    auto& [probability, sum] = of_class[anchor.label];
    sum.resize(things.size());
    probability += r.probability;
    const std::vector<Gaze> directions = hasDirection(relation) ? directions_at(anchor) : std::vector<Gaze>{};
    for (std::size_t i = 0; i < things.size(); ++i) {
      if (things[i] != r.thing) {
        sum[i] += r.probability * likelihoodOf(relation, thingAt(scene, things[i]), anchor, directions);
      }
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

std::vector<double> likelihoodsFarFrom(const QueryScene& scene, const std::vector<int>& things,
                                       const Referents& anchors) {
  std::vector<double> log_sum(things.size(), 0.0);
  double all = 0;
  for (const Referent& r : anchors) {
    const SceneThing& anchor = thingAt(scene, r.thing);
    double farthest = 0;
    for (const int k : things) {
      farthest = std::max(farthest, nearDistance(thingAt(scene, k), anchor));
    }
    for (std::size_t i = 0; i < things.size(); ++i) {
      log_sum[i] += r.probability * std::log(likelihoodFar(thingAt(scene, things[i]), anchor, farthest));
    }
    all += r.probability;
  }
  for (double& v : log_sum) {
    v = std::exp(v / std::max(all, 1e-9));
  }
  return log_sum;
}

std::vector<double> likelihoodsBetween(const QueryScene& scene, const std::vector<int>& things, const Referents& a,
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
