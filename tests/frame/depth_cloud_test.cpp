#include "frame/depth_cloud.h"

#include <gtest/gtest.h>

#include "frame/rig_scene.h"

namespace hgg::depth_cloud_test {
namespace {

DepthImage depth(const RigCamera& camera, std::uint16_t count) {
  DepthImage image;
  image.utime_us = 7;
  image.width = camera.model.width, image.height = camera.model.height;
  image.depth_mm.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), count);
  return image;
}

TEST(DepthCloud, PointsLieAtTheirDepthAlongTheAxis) {
  RigCamera camera = rig_scene::camera("front", 0);
  camera.T_body_camera.translation() << 0.1, 0.2, 0.3;
  const auto cloud = DepthToCloud(camera)(depth(camera, 3000));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->utime_us, 7);
  ASSERT_EQ(cloud->points.size(), 320U * 240);
  for (const Point& p : cloud->points) {
    EXPECT_NEAR(p.x, 3.1, 1e-5);
    EXPECT_EQ(p.label, kUnknownClass);
  }
  EXPECT_NEAR(cloud->points[0].y, 0.2 + 3 * 159.5 / 160, 1e-4);  // the first pixel is top left
  EXPECT_NEAR(cloud->points[0].z, 0.3 + 3 * 119.5 / 160, 1e-4);
  EXPECT_EQ(cloud->p_body_sensor, camera.T_body_camera.translation());
}

TEST(DepthCloud, APointFallsBackOnItsPixelThroughADistortedLens) {
  RigCamera camera = rig_scene::camera("front", 0);
  for (const Lens lens : {Lens::kPinhole, Lens::kFisheye}) {
    camera.model.lens = lens;
    camera.model.distortion = lens == Lens::kPinhole ? std::array{-0.28, 0.07, 0.0002, -0.0003, 0.01}
                                                     : std::array{-0.02, 0.005, -0.001, 0.0002, 0.0};
    camera.depth_stride = 7;
    const auto cloud = DepthToCloud(camera)(depth(camera, 2500));
    ASSERT_TRUE(cloud);
    const Projector project(camera.model);
    std::size_t k = 0;
    for (int y = 0; y < 240; y += 7) {
      for (int x = 0; x < 320; x += 7, ++k) {
        const Point& p = cloud->points[k];
        const auto at = project(camera.T_body_camera.inverse() * Vec3(p.x, p.y, p.z));
        ASSERT_TRUE(at);
        EXPECT_NEAR(at->x(), x, 1e-3);
        EXPECT_NEAR(at->y(), y, 1e-3);
      }
    }
    EXPECT_EQ(k, cloud->points.size());
  }
}

TEST(DepthCloud, DepthsThatAreNotBelievedAreNoPoints) {
  RigCamera camera = rig_scene::camera("front", 0);
  EXPECT_TRUE(DepthToCloud(camera)(depth(camera, 0))->points.empty());
  EXPECT_TRUE(DepthToCloud(camera)(depth(camera, 50))->points.empty());     // below depth_min
  EXPECT_FALSE(DepthToCloud(camera)(depth(camera, 9900))->points.empty());  // 0.0015 / m * 9.9^2 = 0.147 m
  EXPECT_TRUE(DepthToCloud(camera)(depth(camera, 10100))->points.empty());
  camera.depth_noise = 0;
  EXPECT_FALSE(DepthToCloud(camera)(depth(camera, 10100))->points.empty());
  camera.depth_max = 5;
  EXPECT_TRUE(DepthToCloud(camera)(depth(camera, 5001))->points.empty());
  camera.depth_unit = 0.0001;
  EXPECT_FALSE(DepthToCloud(camera)(depth(camera, 5001))->points.empty());
}

TEST(DepthCloud, AnImageOfAnotherSizeIsRefused) {
  const RigCamera camera = rig_scene::camera("front", 0);
  DepthImage image = depth(camera, 3000);
  image.width = 240, image.height = 320;
  EXPECT_FALSE(DepthToCloud(camera)(image));
}

}  // namespace
}  // namespace hgg::depth_cloud_test
