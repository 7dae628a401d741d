// MAP-EM on the leaves of an object: the reference's iteration, the objective, what a prior keeps, odd input.
#include "correction/em.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "core/spd.h"
#include "map/node.h"
#include "random_geometry.h"
#include "reference_vectors.h"

namespace hgg::em_test {
namespace {

using Json = nlohmann::json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3 normalVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  return {x, y, normal(random)};
}

std::vector<Vec3> sampled(std::mt19937& random, const Belief& leaf, int n) {
  const Mat3 root = spdSqrt(leaf.cov);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(leaf.mean + root * normalVector(random));
  }
  return points;
}

/// A square patch of surface around `centre`, `side` wide and 1 cm thick, in the xy plane.
Belief patch(const Vec3& centre, double side, double kappa) {
  return {centre, Vec3(side * side / 12, side * side / 12, 1e-4).asDiagonal().toDenseMatrix(), kappa};
}

std::vector<Belief> withoutEvidence(std::vector<Belief> leaves) {
  for (Belief& leaf : leaves) {
    leaf.kappa = 0;
  }
  return leaves;
}

double evidenceOf(std::span<const Belief> leaves) {
  return std::accumulate(leaves.begin(), leaves.end(), 0.0, [](double sum, const Belief& b) { return sum + b.kappa; });
}

bool isFinite(const Belief& b) { return b.mean.allFinite() && b.cov.allFinite() && std::isfinite(b.kappa); }

double largestDifference(std::span<const Belief> a, std::span<const Belief> b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    largest = std::max(
        {largest, (a[k].mean - b[k].mean).norm(), (a[k].cov - b[k].cov).norm(), std::abs(a[k].kappa - b[k].kappa)});
  }
  return largest;
}

bool areIdentical(std::span<const Belief> a, std::span<const Belief> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Belief& p, const Belief& q) {
    return p.mean == q.mean && p.cov == q.cov && p.kappa == q.kappa;
  });
}

struct Problem {
  std::vector<Belief> prior, start;
  std::vector<Vec3> points;
  EmOptions options;
};

/// Leaves anywhere in a cube, some flat, some with no evidence from before, and points of other leaves.
Problem randomProblem(std::uint32_t seed) {
  std::mt19937 random(seed);
  Problem p;
  for (int k = 0; k < 12; ++k) {
    const Vec3 variances(uniform(random, 0.01, 0.5), uniform(random, 0.01, 0.5), k % 3 == 0 ? 0 : 0.02);
    p.prior.push_back({randomVector(random, 2), rotatedDiagonal(randomRotation(random), variances),
                       k % 4 == 0 ? 0 : uniform(random, 1, 60)});
    p.start.push_back({p.prior.back().mean + randomVector(random, 0.2), p.prior.back().cov,
                       p.prior.back().kappa + uniform(random, 1, 60)});
    for (const Vec3& x : sampled(random, {randomVector(random, 2), randomSpd(random, 1e-3) * 0.3, 1}, 40)) {
      p.points.push_back(x);
    }
  }
  p.options = {std::array{0.0, 1e-4, 1e-2, 0.1}[seed % 4], 20, 3, seed % 3 == 0 ? 1.0 : 2.5};
  return p;
}

EmResult refine(const Problem& p) { return refineLeaves(p.prior, p.start, p.points, p.options); }

struct Reference {
  std::vector<Belief> before, after;
  std::vector<Vec3> points;
  Json json;
};

Reference reference() {
  Reference r;
  r.json = section("em_iteration").at(0);
  for (std::size_t k = 0; k < r.json["means"].size(); ++k) {
    r.before.push_back({vec3(r.json["means"][k]), mat3(r.json["covs"][k]), r.json["kappas"][k]});
    r.after.push_back({vec3(r.json["means_out"][k]), mat3(r.json["covs_out"][k]), r.json["counts"][k]});
  }
  for (const Json& p : r.json["points"]) {
    r.points.push_back(vec3(p));
  }
  return r;
}

TEST(Em, AnIterationWithoutPriorIsTheReferences) {
  const Reference r = reference();
  EmOptions options{r.json["lambda_"], 1, kInfinity, 1};
  const Sight sight = findSight(r.before, r.points, options);
  const Responsibilities printed = eStep(r.before, r.points, sight, 0);
  const Responsibilities with_factor = eStep(r.before, r.points, sight, options.lambda);
  ASSERT_EQ(sight.leaf.size(), r.before.size() * r.points.size());
  for (std::size_t k = 0; k < r.before.size(); ++k) {
    EXPECT_NEAR(printed.gamma[k], r.json["responsibilities_first_point"][k].get<double>(), 1e-9);
    EXPECT_NEAR(with_factor.gamma[k], printed.gamma[k], 1e-9) << "leaves of one shape share the factor";
  }
  EXPECT_NEAR(printed.log_likelihood, r.json["log_likelihood_in"].get<double>(), 1e-9 * 600);
  const std::vector<Belief> nothing = withoutEvidence(r.before);
  EXPECT_LT(largestDifference(mStep(nothing, r.points, sight, printed.gamma, options), r.after), 1e-9);
  EXPECT_LT(largestDifference(refineLeaves(nothing, r.before, r.points, options).leaves, r.after), 1e-9);
}

/// Eqs. e-step, m-step-mu and m-step-sigma with the prior, over every pair that `sees`, written out densely.
template <typename Sees>
std::vector<Belief> denseIteration(const Problem& p, Sees sees) {
  const double lambda = p.options.lambda, w = p.options.point_weight;
  const auto n = static_cast<Eigen::Index>(p.start.size()), count = static_cast<Eigen::Index>(p.points.size());
  Eigen::MatrixXd gamma = Eigen::MatrixXd::Zero(count, n);
  for (Eigen::Index l = 0; l < count; ++l) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const Belief& b = p.start[static_cast<std::size_t>(k)];
      const Mat3 inverse = b.cov.inverse();
      const Vec3 d = p.points[static_cast<std::size_t>(l)] - b.mean;
      gamma(l, k) = sees(l, k) ? b.kappa * std::exp(-0.5 * (d.dot(inverse * d) + lambda * inverse.trace())) /
                                     std::sqrt(b.cov.determinant())
                               : 0;
    }
    gamma.row(l) /= std::max(gamma.row(l).sum(), 1e-300);
  }
  std::vector<Belief> out = p.prior;
  for (Eigen::Index k = 0; k < n; ++k) {
    Belief& b = out[static_cast<std::size_t>(k)];
    const double mass = w * gamma.col(k).sum(), evidence = b.kappa;
    if (mass == 0) {
      continue;
    }
    Vec3 mean = Vec3::Zero();
    for (Eigen::Index l = 0; l < count; ++l) {
      mean += w * gamma(l, k) / mass * p.points[static_cast<std::size_t>(l)];
    }
    Mat3 cov = lambda * Mat3::Identity();
    for (Eigen::Index l = 0; l < count; ++l) {
      const Vec3 d = p.points[static_cast<std::size_t>(l)] - mean;
      cov += w * gamma(l, k) / mass * d * d.transpose();
    }
    const Vec3 d = mean - b.mean;
    const double total = evidence + mass;
    b.cov = (evidence * b.cov + mass * cov + evidence * mass / total * d * d.transpose()) / total;
    b.mean = (evidence * b.mean + mass * mean) / total;
    b.kappa = total;
  }
  return out;
}

/// randomProblem without flat leaves, which a plain inverse cannot serve.
Problem roundProblem(std::uint32_t seed) {
  Problem p = randomProblem(seed);
  for (Belief& b : p.start) {
    b.cov = withFloor(b.cov, 0.35);
  }
  p.options.iterations = 1;
  return p;
}

TEST(Em, AgreesWithDenseBruteForceOverTheSameSight) {
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    const Problem p = roundProblem(seed);
    const auto within_gate = [&](Eigen::Index l, Eigen::Index k) {
      const Belief& b = p.start[static_cast<std::size_t>(k)];
      return mahalanobis(p.points[static_cast<std::size_t>(l)] - b.mean, b.cov) <= p.options.gate;
    };
    EXPECT_LT(largestDifference(refine(p).leaves, denseIteration(p, within_gate)), 1e-12) << seed;
  }
}

TEST(Em, AGateOutsideEverythingThatMattersChangesNothing) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    Problem p = roundProblem(seed);
    p.options.gate = 9;
    const std::vector<Belief> all = denseIteration(p, [](Eigen::Index, Eigen::Index) { return true; });
    EXPECT_LT(largestDifference(refine(p).leaves, all), 1e-6) << seed;
  }
}

TEST(Em, SightIsWhatLiesWithinTheGateOfEachLeaf) {
  std::mt19937 random(5);
  std::vector<Belief> leaves;
  for (int k = 0; k < 60; ++k) {
    const double side = std::exp(uniform(random, std::log(0.1), std::log(5)));
    leaves.push_back(transform(randomPose(random, 5), patch(Vec3::Zero(), side, k % 10 == 0 ? 0 : 1)));
  }
  std::vector<Vec3> points{Vec3(1e4, 0, 0), Vec3::Constant(std::nan("")), Vec3::Constant(kInfinity)};
  for (const Belief& leaf : leaves) {
    const std::vector<Vec3> around = sampled(random, leaf, 30);
    points.insert(points.end(), around.begin(), around.end());
  }
  const Sight sight = findSight(leaves, points, {});
  std::size_t pairs = 0;
  for (std::size_t l = 0; l < points.size(); ++l) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t k = 0; k < leaves.size(); ++k) {
      if (leaves[k].kappa > 0 && mahalanobis(points[l] - leaves[k].mean, leaves[k].cov) <= 3) {
        expected.push_back(k);
      }
    }
    const std::vector<std::uint32_t> found(sight.leaf.begin() + sight.begin[l],
                                           sight.leaf.begin() + sight.begin[l + 1]);
    EXPECT_EQ(found, expected) << l;
    pairs += found.size();
  }
  EXPECT_GT(pairs, 300U);
}

TEST(Em, TheLogPosteriorNeverFalls) {
  double least_gain = kInfinity;
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const EmResult result = refine(randomProblem(seed));
    ASSERT_EQ(result.log_posterior.size(), 20U);
    for (std::size_t t = 1; t < result.log_posterior.size(); ++t) {
      EXPECT_GE(result.log_posterior[t] - result.log_posterior[t - 1], -1e-11 * std::abs(result.log_posterior[t]))
          << "seed " << seed << ", iteration " << t;
    }
    least_gain = std::min(least_gain, result.log_posterior.back() - result.log_posterior.front());
  }
  EXPECT_GT(least_gain, 1) << "the problems must have something to refine";
}

TEST(Em, OnlyWithTheFactorOfLambdaIsAnObjectiveMonotone) {
  std::mt19937 random(3);
  const std::vector<Vec3> points = sampled(random, {Vec3::Zero(), 0.01 * Mat3::Identity(), 1}, 200);
  const std::vector<Belief> best{beliefFromPoints(points)}, nothing = withoutEvidence(best);
  EmOptions options{1e-2, 2, kInfinity, 1};
  const Sight sight = findSight(best, points, options);
  const EmResult result = refineLeaves(nothing, best, points, options);
  EXPECT_GT(result.log_posterior[1], result.log_posterior[0]);
  EXPECT_LT(eStep(result.leaves, points, sight, 0).log_likelihood, eStep(best, points, sight, 0).log_likelihood - 10)
      << "the plain likelihood was at its maximum, and + lambda I leaves it";
}

TEST(Em, ALeafWithoutPointsKeepsItsPrior) {
  std::mt19937 random(7);
  const Belief far = unpackLeaf(packLeaf(randomBelief(random, 1)));
  Belief far_now = far;
  far_now.mean += Vec3(0.1, 0, 0);
  far_now.kappa += 30;
  const std::vector<Belief> prior{patch(Vec3(100, 0, 0), 1, 10), far}, start{prior[0], far_now};
  const EmResult result = refineLeaves(prior, start, sampled(random, prior[0], 100), {});
  EXPECT_TRUE(areIdentical(std::span(result.leaves).last(1), std::span(prior).last(1)));
  const Leaf packed = packLeaf(result.leaves[1]), expected = packLeaf(far);
  EXPECT_EQ(packed.mean, expected.mean);
  EXPECT_EQ(packed.cov, expected.cov);
  EXPECT_EQ(packed.kappa, expected.kappa);
  EXPECT_GT(result.leaves[0].kappa, prior[0].kappa + 90);
}

/// Patches of `side` all over the six faces of a box.
std::vector<Belief> boxLeaves(const Vec3& half, double side, double kappa) {
  std::vector<Belief> leaves;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double sign : {-1.0, 1.0}) {
      for (double a = -half[u] + side / 2; a < half[u]; a += side) {
        for (double b = -half[v] + side / 2; b < half[v]; b += side) {
          Vec3 centre, variances = Vec3::Constant(side * side / 12);
          centre[axis] = sign * half[axis], centre[u] = a, centre[v] = b;
          variances[axis] = 1e-5;
          leaves.push_back({centre, variances.asDiagonal().toDenseMatrix(), kappa});
        }
      }
    }
  }
  return leaves;
}

std::vector<Vec3> boxPoints(std::mt19937& random, const Vec3& half, double least_x, int n) {
  std::vector<Vec3> points;
  while (std::ssize(points) < n) {
    Vec3 p = randomVector(random, 1).cwiseProduct(half);
    const auto axis = static_cast<Eigen::Index>(below(random, 3));
    p[axis] = std::copysign(half[axis], p[axis]);
    if (p.x() >= least_x) {
      points.emplace_back(p + 0.005 * normalVector(random));
    }
  }
  return points;
}

TEST(Em, SurfaceOutOfViewStays) {
  std::mt19937 random(11);
  const Vec3 half(2, 1, 0.75);
  const std::vector<Belief> prior = boxLeaves(half, 0.5, 40);
  std::vector<Vec3> points = boxPoints(random, half, 0.3, 4000);
  for (Vec3& p : points) {
    p += Vec3(0, 0.01, 0);
  }
  const EmResult result = refineLeaves(prior, prior, points, {.iterations = 10});
  int hidden = 0, moved = 0;
  for (std::size_t k = 0; k < prior.size(); ++k) {
    const double motion = (result.leaves[k].mean - prior[k].mean).norm();
    if (prior[k].mean.x() < 0) {
      ++hidden;
      EXPECT_LT(motion, 1e-9) << k;
      EXPECT_NEAR(result.leaves[k].kappa, prior[k].kappa, 1e-9);
    } else {
      moved += motion > 1e-3 ? 1 : 0;
      EXPECT_LT(motion, 0.3) << "a leaf moves within its own patch";
    }
  }
  EXPECT_GT(hidden, 40);
  EXPECT_GT(moved, 30);
}

TEST(Em, EvidenceIsConserved) {
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    Problem p = randomProblem(seed);
    p.options.iterations = 3;
    p.points.emplace_back(500, 500, 500);
    const EmResult result = refine(p);
    EXPECT_GE(result.left_out, 1U);
    EXPECT_NEAR(result.explained, p.options.point_weight * static_cast<double>(p.points.size() - result.left_out),
                1e-9);
    EXPECT_NEAR(evidenceOf(result.leaves), evidenceOf(p.prior) + result.explained, 1e-9 * evidenceOf(result.leaves));
  }
}

TEST(Em, APointOfWeightStandsForThatMany) {
  Problem p = randomProblem(1);
  p.options.point_weight = 3;
  Problem repeated = p;
  repeated.options.point_weight = 1;
  for (int copy = 0; copy < 2; ++copy) {
    repeated.points.insert(repeated.points.end(), p.points.begin(), p.points.end());
  }
  EXPECT_LT(largestDifference(refine(p).leaves, refine(repeated).leaves), 1e-8);
}

/// Mean distance of samples of the leaves, drawn by their evidence, to the nearer of two balls of radius `radius`.
double distanceToClumps(std::mt19937& random, std::span<const Belief> leaves, const Vec3& a, const Vec3& b,
                        double radius) {
  double sum = 0, count = 0;
  for (const Belief& leaf : leaves) {
    for (const Vec3& x : sampled(random, leaf, static_cast<int>(10 * leaf.kappa))) {
      sum += std::max(std::min((x - a).norm(), (x - b).norm()) - radius, 0.0);
      count += 1;
    }
  }
  return sum / count;
}

TEST(Em, LeavesThatBridgeTwoClumpsArePulledOntoThem) {
  const Vec3 a(-0.5, 0, 0), b(0.5, 0, 0);
  double worst_factor = kInfinity;
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    std::mt19937 random(seed);
    std::vector<Vec3> points;
    std::array<std::vector<Vec3>, 2> cut;  // badly: a fifth of each part is of the other clump
    for (std::size_t i = 0; i < 400; ++i) {
      points.emplace_back((i % 2 == 0 ? a : b) + 0.1 * randomVector(random, 1).normalized());
      cut[uniform(random, 0, 1) < 0.8 ? i % 2 : 1 - i % 2].push_back(points.back());
    }
    const std::vector<Belief> bad{beliefFromPoints(cut[0]), beliefFromPoints(cut[1])};
    const EmResult result = refineLeaves(withoutEvidence(bad), bad, points, {.iterations = 10});
    const double before = distanceToClumps(random, bad, a, b, 0.1);
    const double after = distanceToClumps(random, result.leaves, a, b, 0.1);
    worst_factor = std::min(worst_factor, before / after);
    EXPECT_NEAR((result.leaves[0].mean - a).norm(), 0, 0.03) << seed;
    EXPECT_NEAR((result.leaves[1].mean - b).norm(), 0, 0.03) << seed;
  }
  EXPECT_GT(worst_factor, 10);
}

TEST(Em, OddInputGivesNumbers) {
  std::mt19937 random(23);
  const Belief leaf = patch(Vec3(1, 0, 0), 1, 5), point_leaf{Vec3(1, 0, 0), Mat3::Zero(), 1}, unseen{};
  const Belief line{Vec3(1, 0, 0), Vec3(1, 0, 0).asDiagonal().toDenseMatrix(), 2};
  const std::vector<Belief> leaves{leaf, point_leaf, point_leaf, unseen, line};
  const std::vector<Vec3> one(1000, Vec3(1, 0, 0)), aside(1000, Vec3(1.2, 0.1, 0)), none;
  const std::vector<Vec3> broken{Vec3::Constant(std::nan("")), Vec3::Constant(kInfinity), Vec3(1, 0, 0)};
  for (const std::vector<Vec3>& points : {one, aside, none, broken}) {
    for (const double lambda : {0.0, 1e-4}) {
      for (const std::vector<Belief>& prior : {leaves, withoutEvidence(leaves)}) {
        const EmResult result = refineLeaves(prior, leaves, points, {lambda, 20, 3, 1});
        ASSERT_EQ(result.leaves.size(), leaves.size());
        EXPECT_TRUE(std::all_of(result.leaves.begin(), result.leaves.end(), isFinite));
        EXPECT_TRUE(std::all_of(result.log_posterior.begin(), result.log_posterior.end(),
                                [](double x) { return std::isfinite(x); }));
        EXPECT_NEAR(evidenceOf(result.leaves), evidenceOf(prior) + result.explained, 1e-8);
      }
    }
  }
  EXPECT_TRUE(areIdentical(refineLeaves(leaves, leaves, none, {}).leaves, leaves));
  const EmResult nothing = refineLeaves({}, {}, one, {});
  EXPECT_EQ(nothing.left_out, one.size());
  EXPECT_TRUE(nothing.leaves.empty());
  const std::vector<Belief> zero = withoutEvidence(leaves);
  EXPECT_TRUE(areIdentical(refineLeaves(zero, zero, one, {}).leaves, zero)) << "no evidence, no weight";
}

TEST(Em, GivesTheSameTwice) {
  const Problem p = randomProblem(4);
  const EmResult first = refine(p), second = refine(p);
  EXPECT_TRUE(areIdentical(first.leaves, second.leaves));
  EXPECT_EQ(first.log_posterior, second.log_posterior);
}

TEST(Em, MovesWithTheFrame) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    std::mt19937 random(100 + seed);
    const Problem p = randomProblem(seed);
    const Pose T = randomPose(random, seed % 2 == 0 ? 10 : 1e4);
    Problem moved = p;
    for (std::size_t k = 0; k < p.prior.size(); ++k) {
      moved.prior[k] = transform(T, p.prior[k]);
      moved.start[k] = transform(T, p.start[k]);
    }
    for (Vec3& x : moved.points) {
      x = T * x;
    }
    std::vector<Belief> expected = refine(p).leaves;
    for (Belief& b : expected) {
      b = transform(T, b);
    }
    EXPECT_LT(largestDifference(refine(moved).leaves, expected), 1e-6) << seed;
  }
}

}  // namespace
}  // namespace hgg::em_test
