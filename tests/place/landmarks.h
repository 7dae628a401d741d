#pragma once

#include <vector>

#include "place/candidates.h"
#include "random_geometry.h"

namespace hgg {

/// Landmarks to find places among.

inline const Similarity kSame = [](ClassId a, ClassId b) { return a == b ? 1.0 : 0.0; };

inline Landmark landmarkAt(const Vec3& mean, ClassId label = 1, double sigma = 0.05) {
  return {mean, sigma, Vec3::Constant(0.2), label};
}

inline std::vector<Landmark> randomLandmarks(std::mt19937& random, int n, double extent, ClassId label = 1) {
  std::vector<Landmark> landmarks;
  for (int i = 0; i < n; ++i) {
    const Vec3 p = randomVector(random, extent);
    landmarks.push_back(landmarkAt({p.x(), p.y(), 0.05 * p.z()}, label));
  }
  return landmarks;
}

inline Pose uprightPose(double yaw, const Vec3& t) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  T.translation() = t;
  return T;
}

inline std::vector<Landmark> moved(const Pose& T, std::vector<Landmark> landmarks) {
  for (Landmark& l : landmarks) {
    l.mean = T * l.mean;
  }
  return landmarks;
}

}  // namespace hgg
