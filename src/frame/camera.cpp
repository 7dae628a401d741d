#include "frame/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hgg {
namespace {

constexpr int kIterations = 30;  // of undistortion: each gains a digit and more
constexpr double kConverged = 1e-12;

/// r_distorted / r of a pinhole lens, at r^2.
double radialScale(const std::array<double, 5>& k, double r2) { return 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])); }

/// d r_distorted / d r of it.
double radialSlope(const std::array<double, 5>& k, double r2) {
  return 1 + r2 * (3 * k[0] + r2 * (5 * k[1] + r2 * 7 * k[4]));
}

/// Radial-tangential distortion of a place at distance 1 from the camera.
Eigen::Vector2d distort(const std::array<double, 5>& k, const Eigen::Vector2d& p) {
  const double r2 = p.squaredNorm(), xy = p.x() * p.y();
  return radialScale(k, r2) * p + Eigen::Vector2d(2 * k[2] * xy + k[3] * (r2 + 2 * p.x() * p.x()),
                                                  k[2] * (r2 + 2 * p.y() * p.y()) + 2 * k[3] * xy);
}

/// Distance from the axis, in focal lengths, at which a fisheye lens shows the angle theta.
double fisheyeRadius(const std::array<double, 5>& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

double fisheyeSlope(const std::array<double, 5>& k, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

/// The angle that a fisheye lens shows at `radius`, at most `reach`.
double fisheyeAngle(const std::array<double, 5>& k, double radius, double reach) {
  double low = 0, high = reach;  // the radius grows with the angle up to the reach: Newton, kept between bounds
  double theta = std::min(radius, reach);
  for (int i = 0; i < kIterations; ++i) {
    const double error = fisheyeRadius(k, theta) - radius;
    if (std::abs(error) < kConverged) {
      break;
    }
    (error > 0 ? high : low) = theta;
    const double next = theta - error / fisheyeSlope(k, theta);
    theta = next > low && next < high ? next : (low + high) / 2;
  }
  return theta;
}

bool isInside(const CameraModel& camera, double x, double y) {
  return x >= -0.5 && y >= -0.5 && x < camera.width - 0.5 && y < camera.height - 0.5;
}

}  // namespace

bool isIdeal(const CameraModel& camera) {
  return camera.lens == Lens::kPinhole && std::ranges::all_of(camera.distortion, [](double k) { return k == 0; });
}

Mat3 cameraAxes() {
  Mat3 R_body_camera;
  R_body_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_body_camera;
}

double reachOf(const CameraModel& camera) {
  if (isIdeal(camera)) {
    return std::numeric_limits<double>::infinity();
  }
  const bool is_fisheye = camera.lens == Lens::kFisheye;
  constexpr double kStep = 1e-3, kFarthest = 10;  // tangent of the angle: 84 degrees off the axis
  const double end = is_fisheye ? std::numbers::pi : kFarthest;
  for (double r = kStep; r < end; r += kStep) {
    if ((is_fisheye ? fisheyeSlope(camera.distortion, r) : radialSlope(camera.distortion, r * r)) <= 0) {
      return r - kStep;
    }
  }
  return is_fisheye ? end : std::numeric_limits<double>::infinity();
}

Projector::Projector(const CameraModel& camera)
    : camera_(camera), reach_(reachOf(camera)), is_ideal_(isIdeal(camera)) {}

std::optional<ImagePoint> Projector::operator()(const Vec3& p_camera) const {
  Eigen::Vector2d p = p_camera.head<2>();
  if (camera_.lens == Lens::kFisheye) {
    const double across = p.norm(), theta = std::atan2(across, p_camera.z());
    if (!(theta <= reach_) || (across == 0 && p_camera.z() < 0)) {  // right behind it: in no direction
      return std::nullopt;
    }
    p *= across > 0 ? fisheyeRadius(camera_.distortion, theta) / across : 0;
  } else {
    if (!(p_camera.z() > 0)) {
      return std::nullopt;
    }
    p /= p_camera.z();
    if (!is_ideal_) {
      if (p.squaredNorm() > reach_ * reach_) {
        return std::nullopt;
      }
      p = distort(camera_.distortion, p);
    }
  }
  const double x = camera_.fx * p.x() + camera_.cx, y = camera_.fy * p.y() + camera_.cy;
  return isInside(camera_, x, y) ? std::optional(ImagePoint(x, y)) : std::nullopt;
}

Vec3 pixelRay(const CameraModel& camera, double x, double y) {
  const Eigen::Vector2d seen((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
  if (camera.lens == Lens::kFisheye) {
    const double radius = seen.norm(), theta = fisheyeAngle(camera.distortion, radius, reachOf(camera));
    const Eigen::Vector2d across = radius > 0 ? Eigen::Vector2d(seen / radius * std::sin(theta)) : seen;
    return {across.x(), across.y(), std::cos(theta)};
  }
  Eigen::Vector2d p = seen;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector2d error = distort(camera.distortion, p) - seen;
    if (error.squaredNorm() < kConverged * kConverged) {
      break;
    }
    p -= error / std::max(radialSlope(camera.distortion, p.squaredNorm()), 0.1);
  }
  return {p.x(), p.y(), 1};
}

}  // namespace hgg
