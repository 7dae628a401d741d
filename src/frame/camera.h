#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/types.h"

namespace hgg {

/// What a lens does to directions. kPinhole: radial-tangential, k1, k2, p1, p2, k3 (the order of OpenCV and of ROS'
/// "plumb_bob", Kalibr's "radtan"). kFisheye: equidistant, k1 .. k4 (OpenCV's fisheye, Kalibr's "equidistant").
enum class Lens : std::uint8_t { kPinhole, kFisheye };

/// A camera: x right, y down, z forward. Pixel (x, y) covers x-0.5 .. x+0.5.
struct CameraModel {
  Lens lens = Lens::kPinhole;
  int width = 320, height = 240;          // pixel
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixel
  std::array<double, 5> distortion{};     // coefficients in the order of the lens; zeros: none
};

/// A pinhole without distortion.
bool isIdeal(const CameraModel& camera);

/// A place on the image plane, pixels.
using ImagePoint = Eigen::Vector2d;

/// How far off the axis the lens's formula is good: beyond, the image would fold back on itself. The tangent of the
/// angle for pinhole lenses, the angle itself (rad, at most pi) for fisheye lenses.
double reachOf(const CameraModel& camera);

/// A camera made ready for many points.
class Projector {
 public:
  explicit Projector(const CameraModel& camera);
  /// Where a point of the camera's frame is seen; nullopt where it is not: behind the camera, outside the image or
  /// beyond the reach of the lens. Nothing is said of what may hide it.
  std::optional<ImagePoint> operator()(const Vec3& p_camera) const;
  const CameraModel& camera() const { return camera_; }

 private:
  CameraModel camera_;
  double reach_ = std::numeric_limits<double>::infinity();
  bool is_ideal_ = false;  // a pinhole without distortion
};

/// The direction that pixel (x, y) sees: of length 1 along the optical axis for pinhole lenses, a unit vector for
/// fisheye lenses.
Vec3 pixelRay(const CameraModel& camera, double x, double y);

struct Pixel {
  int x = 0, y = 0;
};
/// From the middle of a pixel, where its coordinates are whole, to its edge.
inline constexpr double kHalfPixel = 0.5;
/// The pixel of a place on the image, which must be in it.
inline Pixel pixelAt(const ImagePoint& p) {
  return {static_cast<int>(p.x() + kHalfPixel), static_cast<int>(p.y() + kHalfPixel)};
}

/// Camera axes (x right, y down, z forward) in body axes (x forward, y left, z up).
Mat3 cameraAxes();

}  // namespace hgg
