#include "correction/factors.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/so3.h"
#include "core/spd.h"
#include "random_geometry.h"
#include "reference_vectors.h"

namespace hgg::factors_test {
namespace {

using Json = nlohmann::json;

ObjectObservation seenAs(const Vec3& mean_body, const Mat3& cov_body) {
  ObjectObservation seen;
  seen.mean = mean_body;
  seen.cov = cov_body;
  return seen;
}

/// An information matrix without any structure.
template <int Size>
Eigen::Matrix<double, Size, Size> randomInformation(std::mt19937& random) {
  Eigen::Matrix<double, Size, Size> A;
  for (double& value : A.reshaped()) {
    value = uniform(random, -1, 1);
  }
  return A * A.transpose() + 0.1 * Eigen::Matrix<double, Size, Size>::Identity();
}

/// The factor's derivatives by the tangents of its blocks, [residuals, tangents]: analytic through PlusJacobian, or
/// numeric by central differences through Plus. A block of seven numbers is a pose.
struct Probe {
  const ceres::CostFunction& factor;
  std::vector<std::vector<double>> blocks;

  Eigen::VectorXd residuals(const std::vector<std::vector<double>>& at) const {
    std::vector<const double*> pointers;
    for (const auto& block : at) {
      pointers.push_back(block.data());
    }
    Eigen::VectorXd r(factor.num_residuals());
    factor.Evaluate(pointers.data(), r.data(), nullptr);
    return r;
  }

  Eigen::MatrixXd analytic() const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    std::vector<RowMajor> ambient;
    std::vector<const double*> pointers;
    std::vector<double*> jacobians;
    for (const auto& block : blocks) {
      pointers.push_back(block.data());
      ambient.emplace_back(factor.num_residuals(), static_cast<Eigen::Index>(block.size()));
    }
    for (RowMajor& J : ambient) {
      jacobians.push_back(J.data());
    }
    Eigen::VectorXd r(factor.num_residuals());
    factor.Evaluate(pointers.data(), r.data(), jacobians.data());
    Eigen::MatrixXd all(factor.num_residuals(), 0);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      RowMajor J = ambient[k];
      if (blocks[k].size() == kPoseSize) {
        RowMajor plus(kPoseSize, 6);
        PoseManifold().PlusJacobian(blocks[k].data(), plus.data());
        J = (J * plus).eval();
      }
      all.conservativeResize(Eigen::NoChange, all.cols() + J.cols());
      all.rightCols(J.cols()) = J;
    }
    return all;
  }

  Eigen::MatrixXd numeric(double step) const {
    Eigen::MatrixXd all(factor.num_residuals(), 0);
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const bool pose = blocks[k].size() == kPoseSize;
      for (std::size_t i = 0; i < (pose ? 6 : blocks[k].size()); ++i) {
        Eigen::VectorXd r[2];
        for (int side : {0, 1}) {
          auto moved_blocks = blocks;
          if (pose) {
            Vec6 delta = Vec6::Zero();
            delta[static_cast<Eigen::Index>(i)] = side == 0 ? -step : step;
            PoseManifold().Plus(blocks[k].data(), delta.data(), moved_blocks[k].data());
          } else {
            moved_blocks[k][i] += side == 0 ? -step : step;
          }
          r[side] = residuals(moved_blocks);
        }
        all.conservativeResize(Eigen::NoChange, all.cols() + 1);
        all.rightCols<1>() = (r[1] - r[0]) / (2 * step);
      }
    }
    return all;
  }

  void expectExact() const {
    const Eigen::MatrixXd expected = numeric(1e-5);
    ASSERT_TRUE(expected.allFinite());
    const Eigen::MatrixXd actual = analytic();
    for (Eigen::Index k = 0; k < expected.cols(); ++k) {
      EXPECT_LE((actual.col(k) - expected.col(k)).norm(), 1e-6 * std::max(1.0, expected.col(k).norm()))
          << "column " << k;
    }
  }
};

template <std::size_t Size>
std::vector<double> vectorOf(const std::array<double, Size>& block) {
  return {block.begin(), block.end()};
}

Pose turnedBy(const Vec3& w, const Vec3& t) {
  Pose T = Pose::Identity();
  T.linear() = expRotation(w);
  T.translation() = t;
  return T;
}

TEST(ObjectResidual, EqualsTheReference) {
  for (const Json& c : section("object_residual")) {
    Pose T = Pose::Identity();
    T.linear() = mat3(c["rotation"]);
    T.translation() = vec3(c["translation"]);
    const Vec9 r =
        objectResidual(T, vec3(c["mean"]), spdLog(mat3(c["cov"])), seenAs(vec3(c["mean_obs"]), mat3(c["cov_obs"])));
    const Vec3 r_mu = vec3(c["r_mu"]);
    EXPECT_LE((r.head<3>() - r_mu).norm(), 1e-9 * r_mu.norm());
    const double norm = c["r_sigma_norm"];
    EXPECT_NEAR(r.tail<6>().norm(), norm, 1e-9 * norm);
    for (Eigen::Index k = 0; k < 6; ++k) {  // squares do not depend on the eigenvectors' signs
      EXPECT_NEAR(r[3 + k] * r[3 + k], c["r_sigma_squared"][static_cast<std::size_t>(k)].get<double>(),
                  1e-9 * norm * norm);
    }
  }
}

TEST(ObjectResidual, MeasuresSmallChangesOfAnExtentLikeTheAffineInvariantMetric) {
  for (const Json& c : section("object_residual_isometry")) {
    const Mat3 cov = mat3(c["cov"]);
    const Vec9 r = objectResidual(Pose::Identity(), Vec3::Zero(), spdLog(0.5 * (cov + cov.transpose())),
                                  seenAs(Vec3::Zero(), mat3(c["cov_obs"])));
    const double norm = c["airm_norm"];
    EXPECT_NEAR(r.tail<6>().norm(), norm, c["relative_tolerance"].get<double>() * norm);
  }
}

TEST(ObjectResidual, IsZeroWhereTheObjectIsAsSeenEvenWhenItIsFlatOrRound) {
  std::mt19937 random(1);
  for (const Vec3& variances : {Vec3(1, 1, 1e-6), Vec3(1, 1e-6, 1e-6), Vec3(2, 2, 2), Vec3(4, 1, 0.1)}) {
    const Pose T = randomPose(random, 50);
    const Belief seen{randomVector(random, 20), rotatedDiagonal(randomRotation(random), variances), 100};
    const Belief known = transform(T, seen);
    const Vec9 r =
        objectResidual(T, known.mean, spdLog(0.5 * (known.cov + known.cov.transpose())), seenAs(seen.mean, seen.cov));
    EXPECT_LE(r.norm(), 1e-7);
  }
}

TEST(ObjectFactor, IsTheResidualTimesTheRootsOfItsInformation) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    ObjectObservation seen = seenAs(randomVector(random, 10), randomSpd(random, 1e-3));
    seen.mean_information = randomInformation<3>(random);
    seen.extent_information = uniform(random, 0.1, 50);
    const Pose T = randomPose(random, 10);
    const Vec3 mean = randomVector(random, 10);
    const Mat3 L = spdLog(randomSpd(random, 1e-3));
    const auto factor = objectFactor(seen);
    const Eigen::VectorXd whitened = Probe{*factor, {vectorOf(poseBlock(T)), vectorOf(objectBlock(mean, L))}}.residuals(
        {vectorOf(poseBlock(T)), vectorOf(objectBlock(mean, L))});
    const Vec9 r = objectResidual(T, mean, L, seen);
    const double expected =
        r.head<3>().dot(seen.mean_information * r.head<3>()) + seen.extent_information * r.tail<6>().squaredNorm();
    EXPECT_NEAR(whitened.squaredNorm(), expected, 1e-9 * expected);
  }
}

TEST(ObjectFactor, DerivativesAreExactForFlatRoundAndPlainExtents) {
  std::mt19937 random(3);
  for (const Vec3& variances :
       {Vec3(1, 1, 1e-6), Vec3(1, 1e-6, 1e-6), Vec3(2, 2, 2), Vec3(2, 2 + 1e-7, 1), Vec3(4, 1, 0.1)}) {
    for (int i = 0; i < 20; ++i) {
      ObjectObservation seen = seenAs(randomVector(random, 10), rotatedDiagonal(randomRotation(random), variances));
      seen.mean_information = randomInformation<3>(random);
      seen.extent_information = 3;
      const auto factor = objectFactor(seen);
      const auto object = objectBlock(randomVector(random, 10), spdLog(randomSpd(random, 1e-6)));
      Probe{*factor, {vectorOf(poseBlock(randomPose(random, 10))), vectorOf(object)}}.expectExact();
    }
  }
}

TEST(ObjectFactor, DerivativesAreExactWhereTheBodyIsTurnedAround) {
  std::mt19937 random(4);
  for (const double angle : {0.0, 1e-7, std::numbers::pi - 1e-6, std::numbers::pi}) {
    const auto factor = objectFactor(seenAs(randomVector(random, 10), randomSpd(random, 1e-3)));
    const auto object = objectBlock(randomVector(random, 10), spdLog(randomSpd(random, 1e-3)));
    const Pose T = turnedBy(angle * Vec3(0.6, 0, 0.8), randomVector(random, 10));
    Probe{*factor, {vectorOf(poseBlock(T)), vectorOf(object)}}.expectExact();
  }
}

TEST(BetweenFactor, IsZeroAtTheMeasurementAndWeighsThePoseDifference) {
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    const Pose T_a = randomPose(random, 20), T_b = randomPose(random, 20), measured = randomPose(random, 20);
    const Mat6 information = randomInformation<6>(random);
    const std::vector<std::vector<double>> at{vectorOf(poseBlock(T_a)), vectorOf(poseBlock(T_b))};
    const auto exact = betweenFactor(T_a.inverse() * T_b, information);
    EXPECT_LE((Probe{*exact, at}.residuals(at).norm()), 1e-9);
    const auto off = betweenFactor(measured, information);
    const Vec6 difference = localCoordinates(T_a.inverse() * T_b, measured);
    const double expected = difference.dot(information * difference);
    EXPECT_NEAR((Probe{*off, at}.residuals(at).squaredNorm()), expected, 1e-9 * expected);
  }
}

TEST(BetweenFactor, DerivativesAreExactForAnyErrorUpToNearlyHalfATurn) {
  std::mt19937 random(6);
  for (const double angle : {0.0, 1e-6, 1e-3, 0.5, 2.0, 3.0, std::numbers::pi - 1e-3}) {
    for (int i = 0; i < 10; ++i) {
      const Pose T_a = randomPose(random, 20), T_b = randomPose(random, 20);
      const Vec3 axis = (randomVector(random, 1) + Vec3(0, 0, 1e-3)).normalized();
      const Pose measured = retract(T_a.inverse() * T_b, (Vec6() << randomVector(random, 2), angle * axis).finished());
      const auto factor = betweenFactor(measured, randomInformation<6>(random));
      Probe{*factor, {vectorOf(poseBlock(T_a)), vectorOf(poseBlock(T_b))}}.expectExact();
    }
  }
}

TEST(PosePriorFactor, DerivativesAreExactForAnyErrorUpToNearlyHalfATurn) {
  std::mt19937 random(7);
  for (const double angle : {0.0, 1e-6, 1e-3, 0.5, 2.0, 3.0, std::numbers::pi - 1e-3}) {
    const Pose T = randomPose(random, 20);
    const Vec3 axis = (randomVector(random, 1) + Vec3(0, 0, 1e-3)).normalized();
    const PoseBelief prior{retract(T, (Vec6() << randomVector(random, 2), angle * axis).finished()),
                           randomInformation<6>(random)};
    const auto factor = posePriorFactor(prior);
    Probe{*factor, {vectorOf(poseBlock(T))}}.expectExact();
  }
}

TEST(Factors, BearInformationThatIsZeroInSomeDirections) {
  Mat6 information = Mat6::Zero();
  information(0, 0) = 4;
  const auto factor = posePriorFactor({Pose::Identity(), information});
  const Pose T = turnedBy(Vec3(0.1, 0.2, 0.3), Vec3(1, 2, 3));
  const std::vector<std::vector<double>> at{vectorOf(poseBlock(T))};
  EXPECT_NEAR((Probe{*factor, at}.residuals(at).squaredNorm()), 4, 1e-12);
}

TEST(PoseManifold, IsMovedAndPoseDifference) {
  std::mt19937 random(8);
  const PoseManifold manifold;
  for (int i = 0; i < 50; ++i) {
    const Pose T = randomPose(random, 20);
    const Vec6 tangent = (Vec6() << randomVector(random, 5), randomVector(random, 1.7)).finished();
    const PoseBlock x = poseBlock(T);
    PoseBlock y{};
    manifold.Plus(x.data(), tangent.data(), y.data());
    EXPECT_LE((poseOf(y.data()).matrix() - retract(T, tangent).matrix()).norm(), 1e-12);
    Vec6 back;
    manifold.Minus(y.data(), x.data(), back.data());
    EXPECT_LE((back - tangent).norm(), 1e-10);
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
    manifold.PlusJacobian(x.data(), plus.data());
    manifold.MinusJacobian(x.data(), minus.data());
    EXPECT_LE((minus * plus - Mat6::Identity()).norm(), 1e-12);
  }
}

TEST(ObservationOf, IsWorthFewerPointsThanItHasAndNeverMoreThanItsNoiseAllows) {
  const Belief car{Vec3(5, 0, 0), Vec3(1.5, 0.3, 0.2).asDiagonal().toDenseMatrix(), 100000};
  const ObservationNoise noise{.position = {.view_share = 0.3, .view_noise = 0.03}};
  const ObjectObservation seen = observationOf(car, 1, 0, noise);
  const double count = 1 / (1e-5 + 0.09);
  EXPECT_NEAR(seen.extent_information, count / 2, 1e-9);
  const Mat3 cov = seen.mean_information.inverse();
  EXPECT_LE((cov - (car.cov / count + 9e-4 * Mat3::Identity())).norm(), 1e-12);
  const ObjectObservation sparse = observationOf({car.mean, car.cov, 2}, 1, 0, noise);
  EXPECT_NEAR(sparse.extent_information, 0.5 / (0.5 + 0.09), 1e-9);
}

TEST(ObservationOf, TrustsAViewAsTheModelOfPositionsDoes) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 30; ++trial) {
    const Belief seen = randomBelief(random, 10);
    const ObjectObservation observation = observationOf(seen, 3, 0, {});
    const Mat3 expected = (1 / seen.kappa + 0.49 / 3) * seen.cov + 0.0025 / 3 * Mat3::Identity();
    EXPECT_LE(relativeError(observation.mean_information.inverse(), expected), 1e-9);
    EXPECT_NEAR(observation.extent_information, 0.5 / (1 / seen.kappa + 0.49 / 3), 1e-9);
  }
}

TEST(ObservationOf, WeighsEverythingAlikeInTheAblation) {
  std::mt19937 random(9);
  const ObservationNoise noise{.uniform_weights = true};
  const ObjectObservation a = observationOf(randomBelief(random, 10), 1, 0.01, noise);
  const ObjectObservation b = observationOf(randomBelief(random, 10), 7, 0.01, noise);
  EXPECT_EQ(a.mean_information, b.mean_information);
  EXPECT_EQ(a.extent_information, b.extent_information);
}

}  // namespace
}  // namespace hgg::factors_test
