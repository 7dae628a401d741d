#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "sim/motion.h"
#include "sim/raycaster.h"
#include "truth/poses.h"

namespace hgg::path_world_test {
namespace {

/// Camera poses (x right, y down, z forward) around an oval, `laps` times, at about 5 m/s and 10 Hz, the oval at a
/// gentle slope.
std::vector<Pose> ovalInCameraAxes(double laps) {
  std::vector<Pose> poses;
  constexpr double kFrames = 600;  // a lap
  for (double i = 0; i <= laps * kFrames; ++i) {
    const double angle = 2.0 * M_PI * i / kFrames;
    const Vec3 forward = Vec3(60.0 * std::cos(angle), 0.0, -40.0 * std::sin(angle)).normalized();
    Pose pose = Pose::Identity();
    pose.translation() = Vec3(60.0 * std::sin(angle), 2.0 * std::sin(angle), 40.0 * (std::cos(angle) - 1.0));
    pose.linear().col(2) = forward;
    pose.linear().col(1) = Vec3::UnitY();
    pose.linear().col(0) = Vec3::UnitY().cross(forward);
    poses.push_back(pose);
  }
  return poses;
}

double distanceToWay(const Scene& scene, const Vec3& p) {
  double nearest = 1e9;
  for (double time = 0.0; time < scene.duration; time += 0.1) {
    nearest = std::min(nearest, (scene.T_world_body(time).translation() - p).head<2>().norm());
  }
  return nearest;
}

void expectFree(const Scene& scene) {
  RayCaster caster(scene);
  for (double time = 0.0; time < scene.duration; time += 0.7) {
    caster.setTime(time);
    const Pose T_world_body = scene.T_world_body(time);
    const auto below = caster.cast({T_world_body.translation(), -Vec3::UnitZ()});
    ASSERT_TRUE(below) << time;
    EXPECT_EQ(scene.world.objects[below->object].name, "road") << time;
    EXPECT_NEAR(below->range, 1.65, 0.5) << time;
    for (int i = 0; i < 16; ++i) {
      const double angle = 2.0 * M_PI * i / 16;
      const auto hit =
          caster.cast({T_world_body.translation() - Vec3(0, 0, 0.6), Vec3(std::cos(angle), std::sin(angle), 0)});
      EXPECT_TRUE(!hit || hit->range > 1.2 || scene.world.objects[hit->object].name == "road") << time;
    }
  }
}

TEST(PathWorld, CameraAxesBecomeBodyAxes) {
  const auto poses = ovalInCameraAxes(1.0);
  const Scene scene = pathScene(poses, poses, 1);
  // Camera forward (z) is body x, camera right (x) is minus body y, camera down (y) is minus body z.
  const Vec3 t = poses[100].translation();
  EXPECT_TRUE(scene.T_world_body(10.0).translation().isApprox(Vec3(t.z(), -t.x(), -t.y()), 1e-9));
  for (double time = 1.0; time < 50.0; time += 1.0) {
    const Pose step = scene.T_world_body(time).inverse() * scene.T_world_body(time + 0.1);
    EXPECT_GT(step.translation().x(), 0.95 * step.translation().norm());
    EXPECT_NEAR(scene.T_world_body(time).linear()(2, 2), 1.0, 1e-6);
  }
}

TEST(PathWorld, OdometryIsPassedOnAsItIs) {
  const auto poses = ovalInCameraAxes(0.5);
  auto odometry = poses;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    odometry[i].translation().x() += 0.01 * static_cast<double>(i);
  }
  const Scene scene = pathScene(poses, odometry, 1);
  const Vec3 drift = scene.T_odom_body(20.0).translation() - scene.T_world_body(20.0).translation();
  EXPECT_TRUE(drift.isApprox(Vec3(0, -2.0, 0), 1e-9));
}

TEST(PathWorld, EveryPassOfTheWayIsFree) {
  expectFree(pathScene(ovalInCameraAxes(2.0), ovalInCameraAxes(2.0), 1, 1.0));
}

TEST(PathWorld, ASecondPassAddsNothing) {
  const auto once = ovalInCameraAxes(1.0), twice = ovalInCameraAxes(2.0);
  const Scene one = pathScene(once, once, 4), two = pathScene(twice, twice, 4);
  EXPECT_GT(one.world.objects.size(), 100u);
  EXPECT_NEAR(static_cast<double>(two.world.objects.size()), static_cast<double>(one.world.objects.size()),
              0.1 * static_cast<double>(one.world.objects.size()));
}

TEST(PathWorld, ThingsStandBesideTheWay) {
  const auto poses = ovalInCameraAxes(1.0);
  const Scene scene = pathScene(poses, poses, 2);
  int cars = 0;
  for (const Solid& solid : scene.world.solids) {
    if (scene.world.objects[solid.object].name == "car") {
      EXPECT_GT(distanceToWay(scene, solid.bound_center), 3.0);
      EXPECT_LT(distanceToWay(scene, solid.bound_center), 8.0);
      ++cars;
    }
  }
  EXPECT_GT(cars, 50);
}

TEST(PathWorld, RealTrajectoriesAreFree) {
  const std::filesystem::path data = HGG_SOURCE_DIR "/../shared/data/kitti_trajectories";
  if (!std::filesystem::exists(data)) {
    GTEST_SKIP() << data << " is not here";
  }
  const auto truth = readPoses(data / "07_gt.txt"), odometry = readPoses(data / "07_odometry.txt");
  ASSERT_TRUE(truth && odometry);
  expectFree(pathScene(*truth, *odometry, 1, 1.0));
}

}  // namespace
}  // namespace hgg::path_world_test
