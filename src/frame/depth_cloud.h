#pragma once

#include <optional>

#include "frame/frame.h"
#include "frame/image.h"
#include "frame/rig.h"

namespace hgg {

/// The points of a depth image in the body frame, unlabelled: each depth_stride-th pixel along rows and columns whose
/// depth is believed. Depth comes from disparity or the like: its noise grows with its square (RigCamera::depth_noise).
/// Where it exceeds kMostDepthNoise a depth says nothing, whatever depth_max allows. nullopt when the image is not of
/// the camera's size.
constexpr double kMostDepthNoise = 0.15;  // m, a standard deviation: the leaves of a map are not much larger
class DepthToCloud {
 public:
  explicit DepthToCloud(const RigCamera& camera);
  std::optional<SemanticCloud> operator()(const DepthImage& image) const;

 private:
  RigCamera camera_;
  double farthest_ = 0;                // m along the axis
  std::vector<Eigen::Vector3f> rays_;  // of the pixels taken, body frame, of length 1 along the axis
};

}  // namespace hgg
