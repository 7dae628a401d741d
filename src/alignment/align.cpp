#include "alignment/align.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/spd.h"

namespace hgg {
namespace {

// Measured: docs/experiments.md, "Alignment", has the tables.
constexpr int kEdgeSamples = 1;      // K of eq. edge_cost; two or three changed nothing and cost a millisecond
constexpr double kRobustScale = 2;   // standard deviations; 3 let the far face of a wall pull the pose
constexpr double kLeafNoise = 0.01;  // m, floor of a leaf's thickness
/// Leaves of a frame share its errors: each counts as this share of an independent one.
constexpr double kLeafShare = 0.3;
/// m, the largest standard deviation that regularized() loosens a leaf to. Far above leaf_gate, so that it only keeps
/// the numbers in range; chosen by hand.
constexpr double kLoosest = 5;

std::vector<GaussianPair> objectGaussians(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                          double sigma_floor) {
  std::vector<GaussianPair> gaussians;
  for (const ObjectPair& pair : pairs) {
    const Belief& seen = local.objects[static_cast<std::size_t>(pair.local)].belief;
    const Belief& known = map.find(pair.map)->belief;
    gaussians.push_back({seen.mean, withFloor(seen.cov, sigma_floor), known.mean, withFloor(known.cov, sigma_floor)});
  }
  return gaussians;
}

/// The Gaussian at `gamma` of the way from u to v: the mean on the line, the covariance on the geodesic.
Belief alongEdge(const Belief& u, const Belief& v, double gamma, double sigma_floor) {
  return {(1 - gamma) * u.mean + gamma * v.mean,
          spdGeodesic(withFloor(u.cov, sigma_floor), withFloor(v.cov, sigma_floor), gamma), 0};
}

/// eq. edge_cost: virtual Gaussians along the edges of the frame's graph whose ends are both matched, and along the
/// same lines in the map.
std::vector<GaussianPair> edgeGaussians(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                        double sigma_floor) {
  std::vector<const Belief*> known(local.objects.size(), nullptr);
  for (const ObjectPair& pair : pairs) {
    known[static_cast<std::size_t>(pair.local)] = &map.find(pair.map)->belief;
  }
  std::vector<GaussianPair> gaussians;
  for (const auto& edge : local.edges) {
    const auto a = static_cast<std::size_t>(edge.first), b = static_cast<std::size_t>(edge.second);
    if (known[a] == nullptr || known[b] == nullptr) {
      continue;
    }
    for (int k = 1; k <= kEdgeSamples; ++k) {
      const double gamma = k / (kEdgeSamples + 1.0);
      const Belief seen = alongEdge(local.objects[a].belief, local.objects[b].belief, gamma, sigma_floor);
      const Belief mapped = alongEdge(*known[a], *known[b], gamma, sigma_floor);
      gaussians.push_back({seen.mean, seen.cov, mapped.mean, mapped.cov});
    }
  }
  return gaussians;
}

std::vector<GaussianPair> leafGaussians(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                        const std::vector<LeafPair>& leaf_pairs) {
  std::vector<GaussianPair> gaussians;
  gaussians.reserve(leaf_pairs.size());
  std::vector<const MapNode*> nodes;
  for (const ObjectPair& pair : pairs) {
    nodes.push_back(map.find(pair.map));
  }
  for (const LeafPair& match : leaf_pairs) {
    const auto p = static_cast<std::size_t>(match.pair);
    const LocalObject& object = local.objects[static_cast<std::size_t>(pairs[p].local)];
    const MapNode& node = *nodes[p];
    const Belief seen = transform(object.T_body_object, object.leaves[static_cast<std::size_t>(match.local)]);
    const Belief known = transform(node.T_map_object, unpackLeaf(leavesOf(node)[static_cast<std::size_t>(match.map)]));
    gaussians.push_back({seen.mean, regularized(seen.cov), known.mean, regularized(known.cov)});
  }
  return gaussians;
}

/// The tangent split into directions that the pairs know better than the prior, and directions in which the prior does.
struct Split {
  Mat6 kept;                     // projects a difference to the prior onto what the pairs know better
  Mat6 information;              // of the pairs in these directions
  std::vector<Vec6> degenerate;  // the other directions, normalized
};

Split splitDirections(const Mat6& of_pairs, const Mat6& of_prior) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Mat6> solver(of_pairs, of_prior);
  Split split{Mat6::Zero(), Mat6::Zero(), {}};
  for (int k = 0; k < 6; ++k) {
    const Vec6 v = solver.eigenvectors().col(k);
    if (solver.eigenvalues()[k] < 1) {
      split.degenerate.push_back(v.normalized());
    } else {
      const Vec6 weighed = of_prior * v;
      split.kept += v * weighed.transpose();
      split.information += solver.eigenvalues()[k] * weighed * weighed.transpose();
    }
  }
  return split;
}

}  // namespace

const char* nameOf(PoseSource source) {
  switch (source) {
    case PoseSource::kAligned:
      return "aligned";
    case PoseSource::kDegenerate:
      return "degenerate";
    case PoseSource::kOdometry:
      return "odometry";
  }
  return "";
}

Mat3 regularized(const Mat3& cov) {
  const Eigen3 e = eigenSymmetric(withFloor(cov, kLeafNoise));
  Vec3 variances;
  for (int k = 0; k < 3; ++k) {
    const double flatness = e.values[k] / e.values[0];
    variances[k] = std::min(e.values[k] * flatness * flatness, std::max(kLoosest * kLoosest, e.values[k]));
  }
  return e.vectors * variances.asDiagonal() * e.vectors.transpose();
}

Alignment align(const LocalGraph& local, const Map& map, const PoseBelief& prior, const Config& config) {
  Alignment alignment;
  alignment.pairs = coarseCorrespondence(local, map, prior.T_map_body, config);
  if (config.ablation.odometry_pose) {
    alignment.pose = prior;
    alignment.source = PoseSource::kOdometry;
    return alignment;
  }
  auto objects = objectGaussians(local, map, alignment.pairs, config.creation.sigma_floor);
  const auto edges = edgeGaussians(local, map, alignment.pairs, config.creation.sigma_floor);
  objects.insert(objects.end(), edges.begin(), edges.end());
  Registration found = registerPairs(objects, 1, prior, prior.T_map_body, kRobustScale);
  const auto leaves =
      fineCorrespondence(local, map, alignment.pairs, found.T_map_body, config.alignment, config.creation.sigma_floor);
  found = registerPairs(leafGaussians(local, map, alignment.pairs, leaves), kLeafShare, prior, found.T_map_body,
                        kRobustScale);
  alignment.leaf_pairs = leaves.size();
  const Split split = splitDirections(found.information, prior.information);
  alignment.pose.T_map_body =
      retract(prior.T_map_body, split.kept * localCoordinates(found.T_map_body, prior.T_map_body));
  alignment.pose.information = prior.information + split.information;
  alignment.degenerate_directions = split.degenerate;
  alignment.source = alignment.leaf_pairs == 0  ? PoseSource::kOdometry
                     : split.degenerate.empty() ? PoseSource::kAligned
                                                : PoseSource::kDegenerate;
  return alignment;
}

}  // namespace hgg
