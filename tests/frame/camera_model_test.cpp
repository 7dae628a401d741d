#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "frame/camera.h"

namespace hgg::camera_model_test {
namespace {

CameraModel radtan() {
  CameraModel camera;
  camera.width = 640, camera.height = 480;
  camera.fx = 500, camera.fy = 510, camera.cx = 320, camera.cy = 240;
  camera.distortion = {-0.28, 0.07, 0.0002, -0.0003, 0.01};
  return camera;
}

CameraModel fisheye() {
  CameraModel camera;
  camera.lens = Lens::kFisheye;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 300, camera.cx = 320, camera.cy = 240;
  camera.distortion = {-0.02, 0.005, -0.001, 0.0002, 0};
  return camera;
}

// x = 0.2, y = -0.1, r^2 = 0.05: radial 1 - 0.28 r^2 + 0.07 r^4 + 0.01 r^6 = 0.98617625,
// x' = 0.19723525 + 2 p1 xy + p2 (r^2 + 2 x^2) = 0.19723525 - 0.000008 - 0.000039 = 0.19718825,
// y' = -0.098617625 + p1 (r^2 + 2 y^2) + 2 p2 xy = -0.098617625 + 0.000014 + 0.000012 = -0.098591625.
TEST(CameraModel, PinholeWithDistortionSeesAPointWhereItIsByHand) {
  const auto at = Projector(radtan())(Vec3(0.4, -0.2, 2.0));
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->x(), 320 + 500 * 0.19718825, 1e-9);
  EXPECT_NEAR(at->y(), 240 - 510 * 0.098591625, 1e-9);
}

// theta = pi/4: theta (1 - 0.02 t^2 + 0.005 t^4 - 0.001 t^6 + 0.0002 t^8) = 0.777041337.
TEST(CameraModel, FisheyeSeesAPointWhereItIsByHand) {
  const auto right = Projector(fisheye())(Vec3(1, 0, 1));
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->x(), 320 + 300 * 0.777041337, 1e-6);
  EXPECT_NEAR(right->y(), 240, 1e-9);
  const auto down = Projector(fisheye())(Vec3(0, 0.5, 0.5));
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->y(), 240 + 300 * 0.777041337, 1e-6);
}

TEST(CameraModel, PixelsSeeWhatIsProjectedOnThem) {
  for (const CameraModel& camera : {radtan(), fisheye()}) {
    const Projector project(camera);
    for (const Pixel pixel : {Pixel{0, 0}, Pixel{639, 479}, Pixel{17, 333}, Pixel{320, 240}, Pixel{600, 20}}) {
      const auto back = project(3.7 * pixelRay(camera, pixel.x, pixel.y));
      ASSERT_TRUE(back) << pixel.x << ", " << pixel.y;
      EXPECT_NEAR(back->x(), pixel.x, 1e-6);
      EXPECT_NEAR(back->y(), pixel.y, 1e-6);
    }
  }
}

TEST(CameraModel, SeesNothingBehindOrOutside) {
  const Projector pinhole(radtan()), wide(fisheye());
  for (const Vec3& p : {Vec3(0, 0, -1), Vec3(0, 0, 0), Vec3(5, 0, 1), Vec3(0, NAN, 1)}) {
    EXPECT_FALSE(pinhole(p)) << p.transpose();
  }
  EXPECT_FALSE(wide(Vec3(0, 0, -1)));
  EXPECT_FALSE(wide(Vec3(1, 0, -0.2)));  // 101 degrees off the axis are outside this image
  EXPECT_TRUE(wide(Vec3(1, 0, 0.6)));
}

TEST(CameraModel, AFisheyeSeesBehindItselfWhereItsImageIsLargeEnough) {
  CameraModel camera = fisheye();
  camera.width = 1200, camera.cx = 600, camera.distortion = {};
  const auto at = Projector(camera)(Vec3(1, 0, -0.2));
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->x(), 600 + 300 * (std::numbers::pi / 2 + std::atan(0.2)), 1e-9);
}

TEST(CameraModel, BeyondItsReachALensFoldsNothingBackIntoTheImage) {
  CameraModel camera = radtan();
  camera.distortion = {-0.4, 0, 0, 0, 0};  // r (1 - 0.4 r^2) turns back at r = 0.913, where it is 0.609
  EXPECT_NEAR(reachOf(camera), 0.913, 2e-3);
  EXPECT_FALSE(Projector(camera)(Vec3(1.4, 0, 1)));  // the formula says 1.4 * 0.216 = 0.30: well inside
  EXPECT_TRUE(Projector(camera)(Vec3(0.8, 0, 1)));
}

}  // namespace
}  // namespace hgg::camera_model_test
