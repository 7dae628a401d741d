#include "eval/relative.h"

#include <algorithm>
#include <map>

#include "map/drift.h"
#include "map/position.h"

namespace hgg {
namespace {

struct Found {
  const MapNode* node = nullptr;
  Vec3 true_mean = Vec3::Zero();
};

/// By their anchors, so that each keyframe's drift to all others is searched once.
std::map<KeyframeId, std::vector<Found>> byAnchor(const Map& map, const std::vector<ObjectMatch>& matches,
                                                  std::span<const TruthObject> truth) {
  std::map<std::int64_t, Vec3> true_means;
  for (const TruthObject& object : truth) {
    true_means[object.id] = object.belief.mean;
  }
  std::map<KeyframeId, std::vector<Found>> found;
  for (const ObjectMatch& match : matches) {
    const MapNode* const node = map.find(match.prediction);
    if (node != nullptr) {
      found[node->anchor].push_back({node, true_means.at(match.truth)});
    }
  }
  return found;
}

}  // namespace

Calibration relativeCalibration(const Map& map, const std::vector<ObjectMatch>& matches,
                                std::span<const TruthObject> truth, const Mat3& R_truth_map, double reach) {
  const auto found = byAnchor(map, matches, truth);
  std::vector<double> squares, variances;
  for (auto first = found.begin(); first != found.end(); ++first) {
    const auto from = first->first < 0 ? std::vector<Mat6>() : covariancesFrom(map.keyframes(), first->first);
    for (auto second = first; second != found.end(); ++second) {
      for (const Found& a : first->second) {
        for (const Found& b : second->second) {
          const Vec3 true_apart = b.true_mean - a.true_mean;
          if (true_apart.norm() > reach || (first == second && a.node->id >= b.node->id)) {
            continue;
          }
          const Mat3 cov = R_truth_map * relativeCovariance(map, *a.node, *b.node, from) * R_truth_map.transpose();
          const Vec3 apart = R_truth_map * (b.node->belief.mean - a.node->belief.mean);
          squares.push_back(normalisedSquare(apart - true_apart, cov));
          variances.push_back(cov.trace() / 3);
        }
      }
    }
  }
  return calibrate(squares, variances);
}

}  // namespace hgg
