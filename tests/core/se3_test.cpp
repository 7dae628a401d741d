#include "core/se3.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/so3.h"
#include "random_geometry.h"

namespace hgg::se3_test {
namespace {

double strayOf(const Pose& T) { return (T.linear().transpose() * T.linear() - Mat3::Identity()).norm(); }

TEST(Se3, OrthonormalizedIsRigidAndNearWhatItWas) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    const Pose T = randomPose(random, 100);
    Pose strayed = T;
    for (double& entry : strayed.linear().reshaped()) {
      entry += uniform(random, -1e-4, 1e-4);
    }
    const Pose rigid = orthonormalized(strayed);
    EXPECT_LE(strayOf(rigid), 1e-14);
    EXPECT_NEAR(rigid.linear().determinant(), 1, 1e-14);
    EXPECT_LE((rigid.linear() - T.linear()).norm(), 1e-3);
    EXPECT_EQ(rigid.translation(), T.translation());
  }
}

TEST(Se3, OrthonormalizedLeavesARigidTransformAlone) {
  std::mt19937 random(2);
  for (int run = 0; run < 200; ++run) {
    const Pose T = randomPose(random, 100);
    EXPECT_LE((orthonormalized(T).matrix() - T.matrix()).norm(), 1e-14);
  }
  EXPECT_EQ(orthonormalized(Pose::Identity()).matrix(), Pose::Identity().matrix());
}

/// An inverse by transposition takes for rigid what has strayed: each turn to and fro triples the error that is there.
TEST(Se3, OrthonormalizedKeepsProductsWithInversesRigid) {
  std::mt19937 random(3);
  const auto drivenOn = [&](bool is_mended) {
    Pose T = randomPose(random, 10);
    for (int step = 0; step < 2000; ++step) {
      const Pose to = randomPose(random, 0.01) * T;
      const Pose move = to * T.inverse();
      T = is_mended ? orthonormalized(move * T) : move * T;
    }
    return strayOf(T);
  };
  EXPECT_LE(drivenOn(true), 1e-9);
  EXPECT_FALSE(drivenOn(false) <= 1e-9) << "grows until it is not a number";
}

Vec6 randomTangent(std::mt19937& random, double extent) {
  Vec6 tangent;
  tangent << randomVector(random, extent), randomVector(random, extent);
  return tangent;
}

TEST(Se3, LocalCoordinatesAreTheInverseOfRetract) {
  std::mt19937 random(5);
  for (int run = 0; run < 200; ++run) {
    const Pose T = randomPose(random, 10);
    const Vec6 tangent = randomTangent(random, 1);
    EXPECT_LE((localCoordinates(retract(T, tangent), T) - tangent).norm(), 1e-9);
  }
}

TEST(Se3, RetractTurnsAboutTheBodysOriginInTheOuterFrame) {
  Pose T = Pose::Identity();
  T.translation() = Vec3(5, 0, 0);
  Vec6 tangent;
  tangent << 0, 1, 0, 0, 0, std::numbers::pi / 2;
  const Pose moved = retract(T, tangent);
  EXPECT_TRUE(moved.translation().isApprox(Vec3(5, 1, 0)));
  EXPECT_TRUE((moved.linear() * Vec3::UnitX()).isApprox(Vec3::UnitY()));
}

TEST(Se3, TurnOfAMotionIsItsAngle) {
  std::mt19937 random(6);
  for (const double angle : {0.0, 1e-6, 0.3, 3.1}) {
    Pose T = randomPose(random, 10);
    T.linear() = Eigen::AngleAxisd(angle, randomVector(random, 1).normalized()).toRotationMatrix();
    EXPECT_NEAR(turnOf(T), angle, 1e-9);
  }
}

TEST(Se3, TangentTransportEqualsTheNumericDerivative) {
  constexpr double kStep = 1e-6;
  std::mt19937 random(7);
  for (int run = 0; run < 50; ++run) {
    const Pose T_a_b = randomPose(random, 3), T_b_c = randomPose(random, 3), T_a_c = T_a_b * T_b_c;
    const Mat6 F = tangentTransport(T_a_c.translation() - T_a_b.translation());
    for (int k = 0; k < 6; ++k) {
      const Vec6 numeric = localCoordinates(retract(T_a_b, kStep * Vec6::Unit(k)) * T_b_c, T_a_c) / kStep;
      EXPECT_LE((numeric - F.col(k)).norm(), 1e-4);
    }
  }
}

}  // namespace
}  // namespace hgg::se3_test
