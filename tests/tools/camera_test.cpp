#include "sim/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim/lidar.h"
#include "tools/scratch.h"

namespace hgg::camera_test {
namespace {

const Trajectory kAtRest = [](double) { return Pose::Identity(); };
constexpr RandomKey kKey{7, 0};

/// Ground and twelve boxes around the origin.
Scene boxes() {
  Scene scene;
  addObject(scene.world, 40, false, {Plane{Vec3(0, 0, -1.5), Vec3::UnitZ()}});
  for (int i = 0; i < 12; ++i) {
    const double angle = i * M_PI / 6;
    addObject(scene.world, 10, true,
              {uprightBox(Vec3(6 * std::cos(angle), 6 * std::sin(angle), -1.5), Vec3(1, 1.5, 1.2 + 0.1 * i), angle)});
  }
  return scene;
}

Scan see(const Scene& scene, const RayGrid& grid, const RangeErrors& errors) {
  RayCaster caster(scene);
  return measure(caster, scene.world, grid, errors, kAtRest, {}, kKey, 2);
}

struct Agreement {
  int points = 0, same = 0, inside = 0, inside_same = 0;  // inside: the pixel's neighbours see one object
};

/// Holds the objects of a clean LiDAR's points against those of the pixels they fall on.
Agreement compare(const Scene& scene, const SimCamera& camera) {
  LidarModel lidar = spinningLidar(64, true);
  lidar.errors = {.range_min = 0.1, .range_max = 100.0};
  const RayGrid lidar_grid = lidarGrid(lidar), camera_grid = cameraGrid(camera);
  const Scan cloud = see(scene, lidar_grid, lidar.errors), image = see(scene, camera_grid, camera.errors);
  Agreement agreement;
  for (std::size_t i = 0; i < lidar_grid.size(); ++i) {
    if (cloud.range[i] <= 0) {
      continue;
    }
    const auto pixel = project(camera, static_cast<double>(cloud.range[i]) * lidar_grid.directions[i]);
    if (!pixel || pixel->x < 1 || pixel->y < 1 || pixel->x > camera.model.width - 2 ||
        pixel->y > camera.model.height - 2) {
      continue;
    }
    const std::int32_t object = image.object[camera_grid.at(pixel->x, pixel->y)];
    bool is_inside = true;
    for (int k = 0; k < 9; ++k) {
      is_inside &= image.object[camera_grid.at(pixel->x + k % 3 - 1, pixel->y + k / 3 - 1)] == object;
    }
    ++agreement.points, agreement.same += object == cloud.object[i];
    agreement.inside += is_inside, agreement.inside_same += is_inside && object == cloud.object[i];
  }
  return agreement;
}

TEST(Camera, LabelImageShowsTheObjectsOfTheCloud) {
  for (SimCamera camera : rigCameras(3)) {
    camera.T_body_camera.translation().setZero();  // without parallax both must see the same
    const Agreement agreement = compare(boxes(), camera);
    EXPECT_GT(agreement.inside, 3000) << camera.name;
    EXPECT_EQ(agreement.inside_same, agreement.inside) << camera.name;
    EXPECT_GT(agreement.same, 0.97 * agreement.points) << camera.name;
  }
}

TEST(Camera, OnlyParallaxPartsAMountedCameraFromTheCloud) {
  for (const SimCamera& camera : rigCameras(3)) {
    const Agreement agreement = compare(boxes(), camera);
    EXPECT_GT(agreement.same, 0.93 * agreement.points) << camera.name;
    EXPECT_LT(agreement.same, agreement.points) << camera.name;
  }
}

TEST(Camera, ProjectsWhatItUnprojects) {
  for (const SimCamera& camera : {depthCamera(), rigCameras(3)[1]}) {
    for (const Pixel pixel : {Pixel{0, 0}, Pixel{17, 200}, Pixel{319, 239}}) {
      const auto back = project(camera, unproject(camera, pixel, 3.7));
      ASSERT_TRUE(back);
      EXPECT_EQ(back->x, pixel.x);
      EXPECT_EQ(back->y, pixel.y);
    }
  }
}

TEST(Camera, DoesNotSeeBehindOrBeside) {
  const SimCamera camera = depthCamera();
  EXPECT_TRUE(project(camera, Vec3(3, 0, 0)));
  EXPECT_FALSE(project(camera, Vec3(-3, 0, 0)));
  EXPECT_FALSE(project(camera, Vec3(3, 3, 0)));
}

TEST(Camera, LeftIsToTheLeftAndUpIsUp) {
  const auto cameras = rigCameras(3);
  const Vec3 ahead = cameras[0].T_body_camera.linear() * Vec3::UnitZ();
  const Vec3 left = cameras[1].T_body_camera.linear() * Vec3::UnitZ();
  EXPECT_GT(ahead.x(), 0.99);
  EXPECT_LT(ahead.z(), 0.0);  // looks down a little
  EXPECT_GT(left.y(), 0.99);
  for (const SimCamera& camera : cameras) {
    EXPECT_LT((camera.T_body_camera.linear() * Vec3::UnitY()).z(), -0.99);
    EXPECT_NEAR(camera.T_body_camera.linear().determinant(), 1.0, 1e-12);
  }
}

TEST(Camera, DepthImageUnprojectsOntoTheSurfaces) {
  SimCamera camera = depthCamera();
  camera.errors = {.range_min = 0.3, .range_max = 8.0};
  Scene scene;
  addObject(scene.world, 40, false, {Plane{Vec3(0, 0, -1), Vec3::UnitZ()}});
  const RayGrid grid = cameraGrid(camera);
  const DepthImage image = depthImage(grid, see(scene, grid, camera.errors), 5);
  int measured = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto depth_mm = image.depth_mm[image.at(x, y)];
      if (depth_mm == 0) {
        continue;
      }
      ++measured;
      EXPECT_NEAR(unproject(camera, {x, y}, depth_mm / 1000.0).z(), -1.0, 6e-4);
    }
  }
  EXPECT_GT(measured, 20000);
}

TEST(Camera, DepthThatDoesNotFitIsNotMeasured) {
  const RayGrid grid = cameraGrid(depthCamera());
  Scan scan{std::vector<float>(grid.size(), 70.0F), {}, {}};
  scan.range[grid.at(160, 120)] = 1.0F;
  const DepthImage image = depthImage(grid, scan, 5);
  EXPECT_EQ(image.depth_mm[image.at(159, 120)], 0);
  EXPECT_EQ(image.depth_mm[image.at(160, 120)], 1000);
}

/// Numbers behind "key =" of a rig file, camera by camera.
std::vector<double> numbersOf(const std::string& text, const std::string& key) {
  std::vector<double> numbers;
  for (std::size_t at = text.find("\n" + key + " = "); at != std::string::npos;
       at = text.find("\n" + key + " = ", at + 1)) {
    std::string line = text.substr(at + key.size() + 4, text.find('\n', at + 1) - at - key.size() - 4);
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == '[' || c == ']' || c == ','; }, ' ');
    std::istringstream in(line);
    for (double value = 0; in >> value;) {
      numbers.push_back(value);
    }
  }
  return numbers;
}

TEST(Camera, RigFileCarriesEveryDigit) {
  const Scratch scratch;
  const auto cameras = rigCameras(2);
  ASSERT_EQ(writeRig(cameras, true, (scratch / "rig.toml").string()), "");
  const std::string text = readText(scratch / "rig.toml");
  EXPECT_EQ(numbersOf(text, "fx"), (std::vector<double>{cameras[0].model.fx, cameras[1].model.fx}));
  const auto rows = numbersOf(text, "T_body_camera");
  ASSERT_EQ(rows.size(), 24u);
  for (std::size_t i = 0; i < 24; ++i) {
    const auto row = static_cast<Eigen::Index>(i % 12 / 4), column = static_cast<Eigen::Index>(i % 4);
    EXPECT_EQ(rows[i], cameras[i / 12].T_body_camera.matrix()(row, column));
  }
  EXPECT_NE(text.find("labels = \"CAMERA_LABELS_left\""), std::string::npos);
  EXPECT_EQ(text.find("depth = "), std::string::npos);
  EXPECT_NE(writeRig(cameras, true, "/nonexistent/rig.toml"), "");
}

}  // namespace
}  // namespace hgg::camera_test
