#include "eval/objects.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace hgg {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

double ratio(double part, double whole) { return whole > 0 ? part / whole : kNothing; }

std::vector<double> valuesOf(const std::vector<ObjectMatch>& matches, double ObjectMatch::*value) {
  std::vector<double> values(matches.size());
  std::ranges::transform(matches, values.begin(), value);
  return values;
}

MappedObject withoutGeometry(const MappedObject& object) {
  return {object.id, object.label, object.stuff, object.belief, object.position_cov, {}};
}

/// Pairs of the same class within `radius`, closest first.
std::vector<ObjectMatch> pairsInRange(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                      double radius, const Pose& T_beliefs) {
  std::vector<ObjectMatch> pairs;
  for (const MappedObject& prediction : predictions) {
    for (const TruthObject& object : truth) {
      const Vec3 error = prediction.belief.mean - object.belief.mean;
      const double distance = error.norm();
      if (prediction.label == object.label && distance <= radius) {
        const MappedObject in_map = transform(T_beliefs, withoutGeometry(prediction));
        const Vec3 error_in_map = in_map.belief.mean - object.belief.mean;
        const Mat3 by_points = covarianceOfIndependentPoints(in_map.belief);
        pairs.push_back({prediction.id, object.id, distance, wasserstein2(prediction.belief, object.belief),
                         normalisedSquare(error_in_map, in_map.position_cov), in_map.position_cov.trace() / 3,
                         normalisedSquare(error_in_map, by_points), by_points.trace() / 3});
      }
    }
  }
  std::ranges::sort(pairs, {}, [](const ObjectMatch& m) { return std::tuple(m.distance, m.prediction, m.truth); });
  return pairs;
}

std::vector<ObjectMatch> matchGreedily(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                       double radius, const Pose& T_beliefs) {
  std::set<NodeId> used_predictions;
  std::set<std::int64_t> used_truth;
  std::vector<ObjectMatch> matches;
  for (const ObjectMatch& pair : pairsInRange(predictions, truth, radius, T_beliefs)) {
    if (!used_predictions.contains(pair.prediction) && !used_truth.contains(pair.truth)) {
      used_predictions.insert(pair.prediction);
      used_truth.insert(pair.truth);
      matches.push_back(pair);
    }
  }
  return matches;
}

void removeMatched(std::vector<MappedObject>& predictions, const std::vector<ObjectMatch>& matches) {
  std::set<NodeId> matched;
  for (const ObjectMatch& match : matches) {
    matched.insert(match.prediction);
  }
  std::erase_if(predictions, [&](const MappedObject& p) { return matched.contains(p.id); });
}

ObjectScore score(std::span<const TruthObject> truth, const std::vector<ObjectMatch>& matches,
                  std::span<const MappedObject> ghosts) {
  ObjectScore result{truth.size(), matches.size() + ghosts.size(), matches, {}, {}};
  for (const TruthObject& object : truth) {
    if (std::ranges::find(matches, object.id, &ObjectMatch::truth) == matches.end()) {
      result.missed.push_back(object.id);
    }
  }
  for (const MappedObject& ghost : ghosts) {
    result.ghosts.push_back(ghost.id);
  }
  return result;
}

void append(ObjectScore& sum, const ObjectScore& part) {
  sum.truth += part.truth;
  sum.predicted += part.predicted;
  sum.matches.insert(sum.matches.end(), part.matches.begin(), part.matches.end());
  sum.missed.insert(sum.missed.end(), part.missed.begin(), part.missed.end());
  sum.ghosts.insert(sum.ghosts.end(), part.ghosts.begin(), part.ghosts.end());
}

struct ClassMembers {
  std::vector<MappedObject> predictions;
  std::vector<TruthObject> fixed, dynamic;
};

std::map<ClassId, ClassMembers> byClass(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                        const std::set<ClassId>& only) {
  const auto wanted = [&](ClassId label) { return only.empty() || only.contains(label); };
  std::map<ClassId, ClassMembers> classes;
  for (const MappedObject& prediction : predictions) {
    if (!prediction.stuff && !prediction.dynamic && wanted(prediction.label)) {
      classes[prediction.label].predictions.push_back(prediction);
    }
  }
  for (const TruthObject& object : truth) {
    if (wanted(object.label)) {
      ClassMembers& members = classes[object.label];
      (object.dynamic || object.gone ? members.dynamic : members.fixed).push_back(object);
    }
  }
  return classes;
}

}  // namespace

Spread spreadOf(std::vector<double> values) {
  if (values.empty()) {
    return {kNothing, kNothing, kNothing};
  }
  std::ranges::sort(values);
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  const double median = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  return {sum / static_cast<double>(values.size()), median, values.back()};
}

double ObjectScore::precision() const {
  return ratio(static_cast<double>(matches.size()), static_cast<double>(predicted));
}

double ObjectScore::recall() const { return ratio(static_cast<double>(matches.size()), static_cast<double>(truth)); }

double ObjectScore::f1() const {
  return ratio(2.0 * static_cast<double>(matches.size()), static_cast<double>(truth + predicted));
}

Spread ObjectScore::positionError() const { return spreadOf(valuesOf(matches, &ObjectMatch::distance)); }

Spread ObjectScore::extentError() const { return spreadOf(valuesOf(matches, &ObjectMatch::extent_error)); }

Calibration ObjectScore::calibration() const {
  return calibrate(valuesOf(matches, &ObjectMatch::normalised_square),
                   valuesOf(matches, &ObjectMatch::position_variance));
}

Calibration ObjectScore::calibrationByPoints() const {
  return calibrate(valuesOf(matches, &ObjectMatch::square_by_points),
                   valuesOf(matches, &ObjectMatch::variance_by_points));
}

void markThings(std::vector<MappedObject>& predictions, std::span<const TruthObject> truth) {
  std::set<ClassId> things;
  for (const TruthObject& object : truth) {
    things.insert(object.label);
  }
  for (MappedObject& prediction : predictions) {
    prediction.stuff = prediction.stuff && !things.contains(prediction.label);
  }
}

ObjectEvaluation evaluateObjects(std::span<const MappedObject> predictions, std::span<const TruthObject> truth,
                                 double radius, const std::set<ClassId>& only, const Pose& T_beliefs) {
  ObjectEvaluation evaluation;
  for (auto& [label, members] : byClass(predictions, truth, only)) {
    const auto matches = matchGreedily(members.predictions, members.fixed, radius, T_beliefs);
    removeMatched(members.predictions, matches);
    const auto dynamic = matchGreedily(members.predictions, members.dynamic, radius, T_beliefs);
    removeMatched(members.predictions, dynamic);
    const ObjectScore& result = evaluation.classes[label] = score(members.fixed, matches, members.predictions);
    append(evaluation.overall, result);
    evaluation.dynamic.insert(evaluation.dynamic.end(), dynamic.begin(), dynamic.end());
  }
  return evaluation;
}

}  // namespace hgg
