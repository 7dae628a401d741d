#include "core/so3.h"

#include <cmath>

namespace hgg {

Mat3 skew(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Mat3 expRotation(const Vec3& w) {
  const double angle = w.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Mat3::Identity();
}

Vec3 logRotation(const Mat3& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Mat3 inverseLeftJacobian(const Vec3& w) {
  const double angle = w.norm();
  const Mat3 W = skew(w);
  const double k = angle < 1e-4 ? 1.0 / 12 : 1 / (angle * angle) - 0.5 / (angle * std::tan(0.5 * angle));
  return Mat3::Identity() - 0.5 * W + k * W * W;
}

}  // namespace hgg
