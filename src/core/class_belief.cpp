#include "core/class_belief.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

/// Views that a belief remembers: a minute and a half of frames at 10 Hz. Chosen by hand, not measured.
constexpr double kMostViews = 1000;
/// So many views that miss a thing weigh as much as one that finds it, since segmenters miss more than they make up.
/// Measured on kitti_0001, whose cars are labelled in part of the views only: recall 0.42 with one, 0.92 with two and 1
/// with three; in the simulated worlds two or three make no difference (docs/experiments.md, "Class and existence").
constexpr double kMissesPerFind = 3;
/// The prior of clutter: that of a sighting without points, in views, and the number of points that halves it. Chosen
/// by hand; the last row of the table in docs/experiments.md, "Class and existence", was measured with them.
constexpr double kClutterViews = 2, kClutterPoints = 400;

/// A thing is taken to be solid as if so many views had found nothing but it, until others say what it lets through.
constexpr double kSolidViews = 1;

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

void addPlaceView(ClassBelief& belief, const PlaceView& view, ClassId own) {
  const double held = sumOf(belief.views), taken = std::max(sumOf(view.labels), view.taken), all = taken + view.through;
  const double solid = (held + kSolidViews) / (held + kSolidViews + static_cast<double>(belief.passed));
  const bool is_found = view.is_found > 0 || weightOf(view.labels, own) > 0;
  const double gone = view.is_found > 0 ? 0 : std::max(solid * all - taken, 0.0);
  const double back = view.is_found > 0 ? view.is_found : all > 0 ? taken * taken / all : 0;
  belief.seen_through = static_cast<float>(static_cast<double>(belief.seen_through) * (1 - std::min(back, 1.0)) + gone);
  if (is_found || taken > view.through) {
    belief.passed = static_cast<float>(std::min(static_cast<double>(belief.passed) + view.through, kMostViews));
  }
  addViews(belief, view.labels);
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
  const double gone = std::exp2(static_cast<double>(belief.seen_through)) - 1;
  return found / (found + missed / kMissesPerFind + clutter + gone);
}

}  // namespace hgg
