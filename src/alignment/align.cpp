#include "alignment/align.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "core/spd.h"
#include "core/units.h"

namespace hgg {
namespace {

// Measured: docs/experiments.md, "Alignment", has the tables.
constexpr int kEdgeSamples = 1;      // K of eq. edge_cost; two or three changed nothing and cost a millisecond
constexpr double kRobustScale = 2;   // standard deviations; 3 let the far face of a wall pull the pose
constexpr double kLeafNoise = 0.01;  // m, floor of a leaf's thickness
/// Leaves of a frame share its errors: each counts as this share of an independent one.
constexpr double kLeafShare = 0.3;
/// m, the largest standard deviation that a leaf is loosened to along its surface. Far above leaf_gate, so that it only
/// keeps the numbers in range; chosen by hand.
constexpr double kLoosest = 5;
/// Until its points say otherwise a leaf is a ball of this standard deviation, as a share of the leaf size, worth this
/// many points.
constexpr double kUnseenShare = 0.5, kUnseenPoints = 2;
/// Powers of a leaf's flatness by which it is looser along its surface than across: of one leaf, and of a pair.
constexpr int kLeafPower = 2, kPairPower = 3;

/// 95 % of true priors surprise less (chi-square of three degrees of freedom, divided by three).
constexpr double kSurprising = 2.6;
/// What one frame's alignment can tell, m and rad. Chosen by hand, of the size of odometry's jitter as configured.
constexpr double kTold = 0.01, kToldTurn = 0.05 * kDegree;
/// Directions of which the pairs tell less than this share of what the prior does are taken to be told that much.
constexpr double kBlind = 1e-6;
/// A pose rests when a round moves it by less: m, rad.
constexpr double kRests = 0.01, kRestsTurn = 0.1 * kDegree;
constexpr int kMostRounds = 8;  // what converges does so in three or four

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

/// `cov` with each variance lambda_k times (lambda_k / lambda_min)^power.
Mat3 loosened(const Mat3& cov, int power) {
  const Eigen3 e = eigenSymmetric(cov);
  Vec3 variances = e.values;
  for (int k = 0; k < 3; ++k) {
    const double flatness = e.values[k] / e.values[0];
    for (int i = 0; i < power; ++i) {
      variances[k] *= flatness;
    }
    variances[k] = std::min(variances[k], std::max(kLoosest * kLoosest, e.values[k]));
  }
  return e.vectors * variances.asDiagonal() * e.vectors.transpose();
}

/// The extent of a leaf as far as its points can tell it.
Mat3 extentOf(const Belief& leaf, double leaf_size) {
  const double unseen = kUnseenShare * leaf_size;
  return (leaf.kappa * leaf.cov + kUnseenPoints * unseen * unseen * Mat3::Identity()) / (leaf.kappa + kUnseenPoints);
}

/// The covariance under which the means of two leaves differ, both turned into the map. The sum is loosened, and not
/// each leaf: loosened leaves whose normals differ a little would hold each other where their surfaces intersect.
Mat3 pairCovariance(const Belief& seen, const Belief& known, const Mat3& R_map_body, double leaf_size) {
  const Mat3 sum = R_map_body * extentOf(seen, leaf_size) * R_map_body.transpose() + extentOf(known, leaf_size);
  return loosened(withFloor(sum, std::numbers::sqrt2 * kLeafNoise), kPairPower);
}

/// Leaf pairs of which both leaves have points enough to have an extent.
std::vector<LeafPair> withExtent(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                 std::vector<LeafPair> leaf_pairs) {
  std::erase_if(leaf_pairs, [&](const LeafPair& match) {
    const ObjectPair& pair = pairs[static_cast<std::size_t>(match.pair)];
    const auto& leaves = local.objects[static_cast<std::size_t>(pair.local)].leaves;
    const Leaf& known = leavesOf(*map.find(pair.map))[static_cast<std::size_t>(match.map)];
    return !hasExtent(leaves[static_cast<std::size_t>(match.local)]) || !hasExtent(unpackLeaf(known));
  });
  return leaf_pairs;
}

/// Leaf pairs as registration takes them; `T_map_body` is near the solution.
std::vector<GaussianPair> leafGaussians(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                                        const std::vector<LeafPair>& leaf_pairs, const Pose& T_map_body,
                                        double leaf_size) {
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
    gaussians.push_back(
        {seen.mean, Mat3::Zero(), known.mean, pairCovariance(seen, known, T_map_body.linear(), leaf_size)});
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

/// How far the pairs alone would put the pose from the prior: the squared Mahalanobis distance of its position or its
/// turn, whichever is larger, divided by its three degrees of freedom. About one where the prior is true. `found` is
/// where pairs and prior came to rest together; the pairs alone would be farther off by R P^-1 times as much, with R
/// and P their covariance and the prior's, and R + P is that of the difference.
double surpriseOf(const PoseBelief& prior, const Registration& found) {
  const Vec6 off = localCoordinates(found.T_map_body, prior.T_map_body);
  const Mat6 of_pairs = (found.information + kBlind * prior.information).inverse();
  const Vec6 innovation = off + of_pairs * prior.information * off;
  const Mat6 cov = prior.information.inverse() + of_pairs;
  const Vec3 position = innovation.head<3>(), turn = innovation.tail<3>();
  return std::max(position.dot(cov.topLeftCorner<3, 3>().inverse() * position),
                  turn.dot(cov.bottomRightCorner<3, 3>().inverse() * turn)) /
         3;
}

/// The prior, made no surer than a frame can tell. One that is surer would hold the pose against all leaves, and
/// nothing could surprise it: odometry that stands still at the start of a drive, or after a long rest.
PoseBelief contestable(const PoseBelief& prior) {
  Mat6 cov = prior.information.inverse();
  const bool is_surer = cov.diagonal().head<3>().maxCoeff() < kTold * kTold;
  const bool is_turn_surer = cov.diagonal().tail<3>().maxCoeff() < kToldTurn * kToldTurn;
  if (!is_surer && !is_turn_surer) {
    return prior;
  }
  cov.diagonal().head<3>().array() += is_surer ? kTold * kTold : 0;
  cov.diagonal().tail<3>().array() += is_turn_surer ? kToldTurn * kToldTurn : 0;
  return {prior.T_map_body, cov.inverse()};
}

/// What the alignment of leaves comes to.
struct FineAlignment {
  Registration found;
  PoseBelief prior;  // as far as it was believed
  std::size_t leaf_pairs = 0;
  Fit fit;
};

/// The fine stage. Where it ends at a pose that the prior finds surprising, leaves were too far from their partners to
/// find all of them, and the prior was surer than it should be: its covariance is raised to what was found, and leaves
/// are paired again from there until the pose rests.
FineAlignment alignLeaves(const LocalGraph& local, const Map& map, const std::vector<ObjectPair>& pairs,
                          const PoseBelief& prior, const Pose& T_start, const Config& config) {
  const PoseBelief contested = contestable(prior);
  FineAlignment fine{{T_start, Mat6::Zero(), false}, contested, 0, {}};
  for (int round = 0; round < kMostRounds; ++round) {
    const Pose T_before = fine.found.T_map_body;
    const std::vector<LeafPair> leaves =
        withExtent(local, map, pairs,
                   fineCorrespondence(local, map, pairs, T_before, config.alignment, config.creation.sigma_floor));
    const std::vector<GaussianPair> gaussians =
        leafGaussians(local, map, pairs, leaves, T_before, config.map.leaf_size);
    fine.found = registerPairs(gaussians, kLeafShare, fine.prior, T_before, kRobustScale);
    fine.leaf_pairs = leaves.size();
    const std::size_t stride = leafStride(local, pairs, config.alignment.max_leaf_pairs);
    fine.fit = fitOf(local, pairs, leaves, gaussians, stride, fine.found.T_map_body);
    const double surprise = surpriseOf(contested, fine.found);
    const Vec6 step = localCoordinates(fine.found.T_map_body, T_before);
    const bool rests = step.head<3>().norm() < kRests && step.tail<3>().norm() < kRestsTurn;
    if (surprise < kSurprising && round == 0 && contested.information != prior.information) {  // believed as it came
      fine.prior = prior;
      fine.found = registerPairs(gaussians, kLeafShare, prior, fine.found.T_map_body, kRobustScale);
    }
    if (surprise < kSurprising || (round > 0 && rests)) {
      break;
    }
    fine.prior.information = contested.information / surprise;
  }
  return fine;
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

Mat3 regularized(const Mat3& cov) { return loosened(withFloor(cov, kLeafNoise), kLeafPower); }

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
  const FineAlignment fine = alignLeaves(local, map, alignment.pairs, prior, found.T_map_body, config);
  found = fine.found;
  alignment.leaf_pairs = fine.leaf_pairs;
  alignment.fit = fine.fit;
  const Split split = splitDirections(found.information, fine.prior.information);
  alignment.pose.T_map_body =
      retract(prior.T_map_body, split.kept * localCoordinates(found.T_map_body, prior.T_map_body));
  alignment.pose.information = fine.prior.information + split.information;
  alignment.degenerate_directions = split.degenerate;
  alignment.source = alignment.leaf_pairs == 0  ? PoseSource::kOdometry
                     : split.degenerate.empty() ? PoseSource::kAligned
                                                : PoseSource::kDegenerate;
  return alignment;
}

}  // namespace hgg
