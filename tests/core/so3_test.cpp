#include "core/so3.h"

#include <gtest/gtest.h>

#include "random_geometry.h"

namespace hgg::so3_test {
namespace {

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
