#include "core/class_belief.h"

#include <algorithm>

namespace hgg {
namespace {

constexpr double kMostViews = 1000;
/// A segmenter misses more than it makes up: so many views that miss a thing weigh as much as one that finds it.
constexpr double kMissesPerFind = 3;
/// The clutter that a sighting of no points would be weighed against, in views, and the points that halve it.
constexpr double kClutterViews = 2, kClutterPoints = 400;

void scale(ClassWeights& weights, double factor) {
  for (auto& [label, weight] : weights) {
    weight = static_cast<float>(weight * factor);
  }
}

}  // namespace

void addWeight(ClassWeights& weights, ClassId label, double amount) {
  const auto it = std::lower_bound(weights.begin(), weights.end(), label,
                                   [](const auto& entry, ClassId l) { return entry.first < l; });
  if (it != weights.end() && it->first == label) {
    it->second += static_cast<float>(amount);
  } else {
    weights.insert(it, {label, static_cast<float>(amount)});
  }
}

double weightOf(const ClassWeights& weights, ClassId label) {
  const auto it = std::ranges::find(weights, label, &ClassWeights::value_type::first);
  return it != weights.end() ? static_cast<double>(it->second) : 0;
}

double sumOf(const ClassWeights& weights) {
  double sum = 0;
  for (const auto& [label, weight] : weights) {
    sum += static_cast<double>(weight);
  }
  return sum;
}

void addViews(ClassBelief& belief, const ClassWeights& views) {
  for (const auto& [label, amount] : views) {
    addWeight(belief.views, label, static_cast<double>(amount));
  }
  if (const double all = sumOf(belief.views); all > kMostViews) {
    scale(belief.views, kMostViews / all);
  }
}

ClassId likeliestClass(const ClassBelief& belief, ClassId fallback) {
  const auto it = std::ranges::max_element(belief.views, {}, &ClassWeights::value_type::second);
  return it != belief.views.end() ? it->first : fallback;
}

ClassWeights classProbabilities(const ClassBelief& belief) {
  ClassWeights probabilities = belief.views;
  if (const double all = sumOf(probabilities); all > 0) {
    scale(probabilities, 1 / all);
  }
  return probabilities;
}

double existence(const ClassBelief& belief, ClassId label, double points) {
  const double found = weightOf(belief.views, label);
  const double missed = sumOf(belief.views) - found;
  const double clutter = kClutterViews * kClutterPoints / (kClutterPoints + points);
  return found / (found + missed / kMissesPerFind + clutter);
}

}  // namespace hgg
