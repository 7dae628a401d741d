#include "core/so3.h"

#include <gtest/gtest.h>

#include "random_geometry.h"

namespace hgg::so3_test {
namespace {

double strayOf(const Pose& T) { return (T.linear().transpose() * T.linear() - Mat3::Identity()).norm(); }

TEST(So3, OrthonormalizedIsRigidAndNearWhatItWas) {
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

TEST(So3, OrthonormalizedLeavesARigidTransformAlone) {
  std::mt19937 random(2);
  for (int run = 0; run < 200; ++run) {
    const Pose T = randomPose(random, 100);
    EXPECT_LE((orthonormalized(T).matrix() - T.matrix()).norm(), 1e-14);
  }
  EXPECT_EQ(orthonormalized(Pose::Identity()).matrix(), Pose::Identity().matrix());
}

/// An inverse by transposition takes for rigid what has strayed: each turn to and fro triples the error that is there.
TEST(So3, OrthonormalizedKeepsProductsWithInversesRigid) {
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

TEST(So3, LogIsTheInverseOfExp) {
  std::mt19937 random(4);
  for (int run = 0; run < 200; ++run) {
    const Vec3 w = randomVector(random, 1.7);
    EXPECT_LE((logRotation(expRotation(w)) - w).norm(), 1e-9);
  }
  EXPECT_EQ(expRotation(Vec3::Zero()), Mat3::Identity());
}

}  // namespace
}  // namespace hgg::so3_test
