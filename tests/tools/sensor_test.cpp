#include "sim/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/lidar.h"

namespace hgg::sensor_test {
namespace {

const Trajectory kAtRest = [](double) { return Pose::Identity(); };
constexpr RandomKey kKey{7, 0};

LidarModel cleanLidar() {
  LidarModel lidar;
  lidar.beams = 32;
  lidar.elevation_min_deg = -30;
  lidar.elevation_max_deg = -10;
  lidar.errors = {.range_min = 0.1, .range_max = 1000.0};
  return lidar;
}

Scene groundScene() {
  Scene scene;
  addObject(scene.world, 40, false, {Plane{Vec3(0, 0, -2), Vec3::UnitZ()}});
  return scene;
}

/// A wall across the way at x = `distance`, wide and high.
void addWall(Scene& scene, double distance) {
  addObject(scene.world, 50, false, {uprightBox(Vec3(distance + 0.5, 0, -50), Vec3(1, 200, 100), 0.0)});
}

Scan scanOf(const Scene& scene, const LidarModel& lidar, const Exposure& exposure = {},
            const Trajectory& T_world_body = kAtRest, int threads = 1) {
  RayCaster caster(scene);
  return measure(caster, scene.world, lidarGrid(lidar), lidar.errors, T_world_body, exposure, kKey, threads);
}

/// A narrow bundle of rays along x.
LidarModel lookingAhead() {
  LidarModel lidar = cleanLidar();
  lidar.beams = 100, lidar.columns = 400;
  lidar.field_of_view_deg = 1.0;
  lidar.elevation_min_deg = -0.5, lidar.elevation_max_deg = 0.5;
  return lidar;
}

double shareOf(std::size_t count, const Scan& scan) {
  return static_cast<double>(count) / static_cast<double>(scan.range.size());
}

std::size_t returnsOf(const Scan& scan) {
  return static_cast<std::size_t>(std::count_if(scan.range.begin(), scan.range.end(), [](float r) { return r > 0; }));
}

/// Four standard deviations of a share of n.
double bound(double share, double n) { return 4.0 * std::sqrt(share * (1.0 - share) / n); }

TEST(Sensor, RangesFollowTheGroundAndTheirNoise) {
  LidarModel lidar = cleanLidar();
  lidar.errors.noise = 0.05;
  const RayGrid grid = lidarGrid(lidar);
  const Scan scan = scanOf(groundScene(), lidar);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double error = scan.range[i] - 2.0 / -grid.directions[i].z();
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(grid.size());
  EXPECT_NEAR(sum / n, 0.0, 4 * 0.05 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), 0.05, 4 * 0.05 / std::sqrt(2 * n));
}

TEST(Sensor, DepthNoiseGrowsWithTheSquareOfTheRange) {
  for (const double distance : {2.0, 6.0}) {
    Scene scene;
    addWall(scene, distance);
    LidarModel lidar = lookingAhead();
    lidar.errors.noise = 0.001, lidar.errors.noise_per_m2 = 0.002;
    double squares = 0;
    const Scan scan = scanOf(scene, lidar);
    const RayGrid grid = lidarGrid(lidar);
    for (std::size_t i = 0; i < grid.size(); ++i) {
      squares += std::pow(scan.range[i] - distance / grid.directions[i].x(), 2);
    }
    const double expected = 0.001 + 0.002 * distance * distance;
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(grid.size())), expected, 0.03 * expected);
  }
}

TEST(Sensor, ReturnsOutOfRangeAreNotMeasuredButSeen) {
  LidarModel lidar = cleanLidar();
  lidar.elevation_min_deg = -80, lidar.elevation_max_deg = -1;
  lidar.errors.range_min = 3.0, lidar.errors.range_max = 20.0;
  const Scan scan = scanOf(groundScene(), lidar);
  const RayGrid grid = lidarGrid(lidar);
  std::size_t lost = 0;
  for (std::size_t i = 0; i < scan.range.size(); ++i) {
    const double range = 2.0 / -grid.directions[i].z();
    EXPECT_EQ(scan.range[i] > 0, range >= 3.0 && range <= 20.0);
    EXPECT_EQ(scan.object[i], 0);
    lost += scan.range[i] <= 0;
  }
  EXPECT_GT(lost, 0u);
}

TEST(Sensor, DropoutsComeAtTheirRate) {
  LidarModel lidar = cleanLidar();
  lidar.errors.dropout = 0.07;
  const Scan scan = scanOf(groundScene(), lidar);
  EXPECT_NEAR(shareOf(returnsOf(scan), scan), 0.93, bound(0.93, static_cast<double>(scan.range.size())));
}

TEST(Sensor, GrazingRaysAreLostInProportion) {
  LidarModel lidar = cleanLidar();
  lidar.beams = 1, lidar.columns = 40000;
  lidar.errors.grazing_deg = 4.0;
  for (const double elevation_deg : {1.0, 2.0, 3.0, 4.5}) {
    lidar.elevation_min_deg = lidar.elevation_max_deg = -elevation_deg;
    const Scan scan = scanOf(groundScene(), lidar);
    const double expected = std::min(1.0, std::sin(elevation_deg * M_PI / 180) / std::sin(4.0 * M_PI / 180));
    EXPECT_NEAR(shareOf(returnsOf(scan), scan), expected, bound(expected, 40000)) << elevation_deg;
  }
}

Scene hedgeBeforeWall() {
  Scene scene;
  addWall(scene, 20.0);
  addObject(scene.world, {.label = 70, .foliage = true, .name = "vegetation"},
            {uprightBox(Vec3(11, 0, -50), Vec3(2, 200, 100), 0.0)});  // x 10..12
  return scene;
}

TEST(Sensor, FoliageReturnsAtExponentialDepthOrLetsTheRayPass) {
  LidarModel lidar = lookingAhead();
  lidar.errors.foliage_depth = 1.0;
  const Scan scan = scanOf(hedgeBeforeWall(), lidar);
  const auto n = static_cast<double>(scan.range.size());
  double passed = 0, first_half_metre = 0;
  for (std::size_t i = 0; i < scan.range.size(); ++i) {
    passed += scan.object[i] == 0;
    first_half_metre += scan.object[i] == 1 && scan.range[i] < 10.5;
    EXPECT_TRUE(scan.object[i] == 0 ? scan.range[i] > 19.99 : scan.range[i] > 9.99 && scan.range[i] < 12.01);
  }
  EXPECT_NEAR(passed / n, std::exp(-2.0), bound(std::exp(-2.0), n));
  EXPECT_NEAR(first_half_metre / n, 1 - std::exp(-0.5), bound(std::exp(-0.5), n));
}

TEST(Sensor, FoliageIsSolidWithoutDepth) {
  const Scan scan = scanOf(hedgeBeforeWall(), lookingAhead());
  EXPECT_TRUE(std::all_of(scan.range.begin(), scan.range.end(), [](float r) { return std::abs(r - 10.0) < 0.01; }));
}

TEST(Sensor, ATrunkInsideFoliageIsSeenThroughIt) {
  Scene scene = hedgeBeforeWall();
  addObject(scene.world, 71, true, {uprightBox(Vec3(11.5, 0, -50), Vec3(0.2, 200, 100), 0.0)});  // from x = 11.4
  LidarModel lidar = lookingAhead();
  lidar.errors.foliage_depth = 1.0;
  const Scan scan = scanOf(scene, lidar);
  const double trunk = shareOf(static_cast<std::size_t>(std::count(scan.object.begin(), scan.object.end(), 2)), scan);
  EXPECT_NEAR(trunk, std::exp(-1.4), bound(std::exp(-1.4), static_cast<double>(scan.range.size())));
  EXPECT_EQ(std::count(scan.object.begin(), scan.object.end(), 0), 0);
}

TEST(Sensor, MixedReturnsLieBetweenTheSurfacesOfAnEdge) {
  Scene scene;
  addWall(scene, 20.0);
  addObject(scene.world, 80, true, {uprightBox(Vec3(10, 0, -50), Vec3(0.2, 0.06, 100), 0.0)});
  LidarModel lidar = lookingAhead();
  lidar.beams = 2000;
  lidar.errors.mixed = 0.3;
  const RayGrid grid = lidarGrid(lidar);
  const Scan scan = scanOf(scene, lidar);
  int edges = 0, mixed = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t i = grid.at(x, y);
      const auto differs = [&](int nx) {
        return nx >= 0 && nx < grid.width && scan.object[grid.at(nx, y)] != scan.object[i];
      };
      const bool is_edge = differs(x - 1) || differs(x + 1);
      edges += is_edge;
      mixed += scan.mixed[i];
      EXPECT_TRUE(is_edge || !scan.mixed[i]);
      EXPECT_GT(scan.range[i], 9.8);
      EXPECT_LT(scan.range[i], 20.1);
      EXPECT_TRUE(scan.mixed[i] || scan.range[i] < 10.0 || scan.range[i] > 19.9);
    }
  }
  EXPECT_EQ(edges, 4 * grid.height);
  EXPECT_NEAR(static_cast<double>(mixed) / edges, 0.3, bound(0.3, edges));
}

TEST(Sensor, AColumnIsNextToTheLastOnlyOnAFullTurn) {
  EXPECT_TRUE(lidarGrid(spinningLidar(16, false)).wraps);
  const RayGrid solid = lidarGrid(solidStateLidar(false));
  EXPECT_FALSE(solid.wraps);
  for (const Vec3& d : solid.directions) {
    EXPECT_GT(d.x(), std::cos(60.01 * M_PI / 180) * std::cos(13.0 * M_PI / 180) - 0.02);
  }
}

TEST(Sensor, ThreadsChangeNothing) {
  Scene scene = hedgeBeforeWall();
  addObject(scene.world, 40, false, {Plane{Vec3(0, 0, -2), Vec3::UnitZ()}});
  const LidarModel lidar = spinningLidar(64, false);
  const Trajectory moving = [](double t) { return Pose(Eigen::Translation3d(t, 0, 0)); };
  const Scan one = scanOf(scene, lidar, {1.0, 0.1}, moving, 1), three = scanOf(scene, lidar, {1.0, 0.1}, moving, 3);
  EXPECT_EQ(one.range, three.range);
  EXPECT_EQ(one.object, three.object);
  EXPECT_EQ(one.mixed, three.mixed);
}

Trajectory fastTurn() {
  return [](double t) {
    Pose pose = Pose::Identity();
    pose.translation() = Vec3(12.0 * t, 0.5 * t, 0);
    pose.linear() = Eigen::AngleAxisd(0.8 * t, Vec3::UnitZ()).toRotationMatrix();
    return pose;
  };
}

TEST(Sensor, MotionDistortionUndoneByTrueMotionLiesOnTheSurfaces) {
  Scene scene = groundScene();
  addWall(scene, 30.0);
  LidarModel lidar = cleanLidar();
  lidar.elevation_max_deg = 10.0;
  const Exposure exposure{1.0, 0.1};
  const RayGrid grid = lidarGrid(lidar);
  const Trajectory T_world_body = fastTurn();
  const Scan scan = scanOf(scene, lidar, exposure, T_world_body);
  double worst_undone = 0, worst_distorted = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t i = grid.at(x, y);
      if (scan.range[i] <= 0) {
        continue;
      }
      const Vec3 p_body = static_cast<double>(scan.range[i]) * grid.directions[i];
      const auto offSurface = [&](const Pose& T) {
        const Vec3 p = T * p_body;
        return scan.object[i] == 0 ? std::abs(p.z() + 2.0) : std::abs(p.x() - 30.0);
      };
      worst_undone = std::max(worst_undone, offSurface(T_world_body(columnTime(grid, exposure, x))));
      worst_distorted = std::max(worst_distorted, offSurface(T_world_body(exposure.time)));
    }
  }
  EXPECT_LT(worst_undone, 1e-4);
  EXPECT_GT(worst_distorted, 0.5);
}

TEST(Sensor, TheLastColumnIsMeasuredAtTheTimeOfTheFrame) {
  const RayGrid grid = lidarGrid(cleanLidar());
  EXPECT_DOUBLE_EQ(columnTime(grid, {5.0, 0.1}, grid.width - 1), 5.0);
  EXPECT_NEAR(columnTime(grid, {5.0, 0.1}, 0), 4.9 + 0.1 / grid.width, 1e-12);
  EXPECT_DOUBLE_EQ(columnTime(grid, {5.0, 0.0}, 0), 5.0);
}

TEST(Sensor, WhatMovesIsMeasuredWhereItIsDuringTheSweep) {
  Scene scene;
  addObject(scene.world, 10, true, {uprightBox(Vec3(10.5, 0, -50), Vec3(1, 200, 100), 0.0)});
  scene.motions.push_back({0, [](double t) { return std::optional<Pose>(Eigen::Translation3d(10.0 * t, 0, 0)); }});
  const LidarModel lidar = lookingAhead();
  const RayGrid grid = lidarGrid(lidar);
  const Exposure exposure{1.0, 0.2};
  const Scan scan = scanOf(scene, lidar, exposure);
  for (int x = 0; x < grid.width; ++x) {
    EXPECT_NEAR(scan.range[grid.at(x, 0)], 10.0 + 10.0 * columnTime(grid, exposure, x), 10.0 * 0.2 / 16);
  }
}

TEST(Sensor, ParallelForVisitsEachOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> visits(100, 0);
    parallelFor(100, threads, [&](int i) { ++visits[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(visits, std::vector<int>(100, 1));
  }
  parallelFor(0, 2, [](int) { FAIL(); });
}

}  // namespace
}  // namespace hgg::sensor_test
