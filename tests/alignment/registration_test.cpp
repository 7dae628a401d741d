#include "alignment/registration.h"

#include <gtest/gtest.h>

#include "random_geometry.h"
#include "reference_vectors.h"

namespace hgg::registration_test {
namespace {

using Json = nlohmann::json;

constexpr double kNoRobust = 1e6;  // so large that the kernel is the square

Pose poseOf(const Mat3& R, const Vec3& t) {
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

struct ReferenceCase {
  std::vector<GaussianPair> pairs;
  Pose T_true, T_probe;
  double cost_at_probe = 0;
};

std::vector<ReferenceCase> referenceCases() {
  std::vector<ReferenceCase> cases;
  for (const Json& c : section("registration")) {
    ReferenceCase r{{},
                    poseOf(mat3(c["rotation_true"]), vec3(c["translation_true"])),
                    poseOf(mat3(c["rotation_probe"]), vec3(c["translation_probe"])),
                    c["node_cost_at_probe"]};
    for (std::size_t i = 0; i < c["local_means"].size(); ++i) {
      r.pairs.push_back(
          {vec3(c["local_means"][i]), mat3(c["local_covs"][i]), vec3(c["map_means"][i]), mat3(c["map_covs"][i])});
    }
    cases.push_back(std::move(r));
  }
  return cases;
}

/// Pairs that do not fit exactly, so that gradients are not zero anywhere.
std::vector<GaussianPair> noisyPairs(std::mt19937& random, int count, const Pose& T_map_body, double noise) {
  std::vector<GaussianPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Belief seen = randomBelief(random, 10);
    const Belief known = transform(T_map_body, seen);
    const Vec3 off(uniform(random, -noise, noise), uniform(random, -noise, noise), uniform(random, -noise, noise));
    pairs.push_back(
        {seen.mean, seen.cov + 0.01 * Mat3::Identity(), known.mean + off, known.cov + 0.02 * Mat3::Identity()});
  }
  return pairs;
}

void expectSamePose(const Pose& actual, const Pose& expected, double tolerance) {
  EXPECT_LE(localCoordinates(actual, expected).norm(), tolerance) << actual.matrix() << "\nexpected\n"
                                                                  << expected.matrix();
}

TEST(RegistrationCost, EqualsTheReferenceAtItsProbe) {
  for (const ReferenceCase& c : referenceCases()) {
    EXPECT_NEAR(registrationCost(c.pairs, c.T_probe), c.cost_at_probe, 1e-9 * c.cost_at_probe);
    EXPECT_NEAR(registrationCost(c.pairs, c.T_true), 0, 1e-9);
  }
}

TEST(RegisterPairs, FindsTheReferencesPoseFromItsProbeForwardAndInverse) {
  for (const ReferenceCase& c : referenceCases()) {
    const PoseBelief no_prior{c.T_probe, Mat6::Zero()};
    const Registration found = registerPairs(c.pairs, 1, no_prior, c.T_probe, kNoRobust);
    EXPECT_TRUE(found.converged);
    expectSamePose(found.T_map_body, c.T_true, 1e-7);
    std::vector<GaussianPair> swapped;
    for (const GaussianPair& p : c.pairs) {
      swapped.push_back({p.mean_map, p.cov_map, p.mean_body, p.cov_body});
    }
    const Registration back =
        registerPairs(swapped, 1, {c.T_probe.inverse(), Mat6::Zero()}, c.T_probe.inverse(), kNoRobust);
    expectSamePose(back.T_map_body, c.T_true.inverse(), 1e-6);
  }
}

TEST(RegisterPairs, FindsThePoseFromPerturbedStarts) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose T = randomPose(random, 20);
    const auto pairs = noisyPairs(random, 12, T, 0);
    Vec6 offset;
    for (int k = 0; k < 6; ++k) {
      offset[k] = uniform(random, -0.5, 0.5);
    }
    const Pose T_start = retract(T, offset);
    expectSamePose(registerPairs(pairs, 1, {T_start, Mat6::Zero()}, T_start, kNoRobust).T_map_body, T, 1e-6);
  }
}

TEST(Linearize, GradientEqualsTheNumericOneWithAndWithoutTheKernel) {
  std::mt19937 random(2);
  for (const double robust_scale : {0.5, 2.0, kNoRobust}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Pose T_true = randomPose(random, 10);
      const auto pairs = noisyPairs(random, 8, T_true, 0.5);
      const Pose T = retract(T_true, 0.1 * Vec6::Ones());
      const Vec6 gradient = linearize(pairs, T, robust_scale).gradient;
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 6; ++k) {
        const double above = linearize(pairs, retract(T, kStep * Vec6::Unit(k)), robust_scale).cost;
        const double below = linearize(pairs, retract(T, -kStep * Vec6::Unit(k)), robust_scale).cost;
        EXPECT_NEAR(gradient[k], (above - below) / (2 * kStep), 1e-5 * std::max(1.0, gradient.norm())) << k;
      }
    }
  }
}

TEST(RegisterPairs, GradientVanishesAtTheSolutionPriorIncluded) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose T_true = randomPose(random, 10);
    const auto pairs = noisyPairs(random, 10, T_true, 0.1);
    const PoseBelief prior{retract(T_true, 0.05 * Vec6::Ones()), 50 * Mat6::Identity()};
    const Pose T = registerPairs(pairs, 0.7, prior, prior.T_map_body, 1.5).T_map_body;
    const auto total = [&](const Pose& at) {
      const Vec6 xi = localCoordinates(at, prior.T_map_body);
      return 0.7 * linearize(pairs, at, 1.5).cost + xi.dot(prior.information * xi);
    };
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 6; ++k) {
      const double slope =
          (total(retract(T, kStep * Vec6::Unit(k))) - total(retract(T, -kStep * Vec6::Unit(k)))) / (2 * kStep);
      EXPECT_NEAR(slope, 0, 0.02) << k;  // 10 um from the minimum; at the prior it is 5
    }
  }
}

TEST(RegisterPairs, WithoutPairsItIsThePrior) {
  std::mt19937 random(4);
  const PoseBelief prior{randomPose(random, 5), 100 * Mat6::Identity()};
  const Registration found = registerPairs({}, 1, prior, retract(prior.T_map_body, 0.3 * Vec6::Ones()), 2);
  expectSamePose(found.T_map_body, prior.T_map_body, 1e-6);
  EXPECT_EQ(found.information.norm(), 0);
}

TEST(RegisterPairs, OneWrongPairInTenHardlyMovesThePose) {
  std::mt19937 random(5);
  const Pose T = randomPose(random, 5);
  auto pairs = noisyPairs(random, 10, T, 0);
  pairs[3].mean_map += Vec3(8, -6, 2);
  const PoseBelief weak{retract(T, 0.05 * Vec6::Ones()), 1e-3 * Mat6::Identity()};
  const Pose robust = registerPairs(pairs, 1, weak, weak.T_map_body, 0.5).T_map_body;
  const Pose square = registerPairs(pairs, 1, weak, weak.T_map_body, kNoRobust).T_map_body;
  EXPECT_LT(localCoordinates(robust, T).norm(), 0.2 * localCoordinates(square, T).norm());
}

TEST(PoseDifference, IsUndoneByMoved) {
  std::mt19937 random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Pose a = randomPose(random, 10), b = randomPose(random, 10);
    expectSamePose(retract(b, localCoordinates(a, b)), a, 1e-9);
  }
  EXPECT_EQ(localCoordinates(Pose::Identity(), Pose::Identity()).norm(), 0);
}

}  // namespace
}  // namespace hgg::registration_test
