#include "core/se3.h"

#include "core/so3.h"

namespace hgg {

Pose retract(const Pose& T, const Vec6& tangent) {
  Pose out = T;
  out.linear() = Eigen::Quaterniond(expRotation(tangent.tail<3>()) * T.linear()).normalized().toRotationMatrix();
  out.translation() += tangent.head<3>();
  return out;
}

Vec6 localCoordinates(const Pose& T, const Pose& T_0) {
  Vec6 xi;
  xi << T.translation() - T_0.translation(), logRotation(T.linear() * T_0.linear().transpose());
  return xi;
}

double turnOf(const Pose& T) { return Eigen::AngleAxisd(T.linear()).angle(); }

Mat6 tangentTransport(const Vec3& arm) {
  Mat6 F = Mat6::Identity();
  F.topRightCorner<3, 3>() = skew(-arm);
  return F;
}

Pose orthonormalized(const Pose& T) {
  Pose rigid = T;
  rigid.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return rigid;
}

}  // namespace hgg
