#include <gtest/gtest.h>

#include <cmath>

#include "sim/raycast.h"
#include "sim/scene.h"

namespace hgg::sim_test {
namespace {

TEST(Sim, YardIsALapWithoutCollisions) {
  const Scene yard = makeYard(1);
  for (double time = 0; time < 20.0; time += 0.1) {
    const Vec3 at = yard.T_world_body(time).translation();
    const double speed = (yard.T_world_body(time + 0.01).translation() - at).head<2>().norm() / 0.01;
    ASSERT_GT(speed, 1.0);
    ASSERT_LT(speed, 5.0);
    for (int i = 0; i < 36; ++i) {
      const auto hit = castRay(yard.world, {at, Vec3(std::cos(i * M_PI / 18), std::sin(i * M_PI / 18), 0)});
      ASSERT_TRUE(!hit || hit->range > 1.5) << "object " << hit->object << " is on the road at " << time << " s";
    }
  }
  EXPECT_LT((yard.T_world_body(20.0).translation() - yard.T_world_body(0.0).translation()).norm(), 0.1);
}

TEST(Sim, UnknownWorldIsNotMade) { EXPECT_FALSE(makeScene("atlantis", 1)); }

}  // namespace
}  // namespace hgg::sim_test
