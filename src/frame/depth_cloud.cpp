#include "frame/depth_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hgg {

DepthToCloud::DepthToCloud(const RigCamera& camera) : camera_(camera) {
  const double by_noise = camera.depth_noise > 0 ? std::sqrt(kMostDepthNoise / camera.depth_noise)
                                                 : std::numeric_limits<double>::infinity();
  farthest_ = camera.depth_max > 0 ? std::min(camera.depth_max, by_noise) : by_noise;
  const Mat3 R_body_camera = camera.T_body_camera.linear();
  for (int y = 0; y < camera.model.height; y += camera.depth_stride) {
    for (int x = 0; x < camera.model.width; x += camera.depth_stride) {
      const Vec3 ray = pixelRay(camera.model, x, y);
      const bool is_ahead = ray.z() > 1e-3;  // a fisheye sees what has no depth
      rays_.emplace_back(is_ahead ? Eigen::Vector3f((R_body_camera * (ray / ray.z())).cast<float>())
                                  : Eigen::Vector3f::Zero());
    }
  }
}

std::optional<SemanticCloud> DepthToCloud::operator()(const DepthImage& image) const {
  if (image.width != camera_.model.width || image.height != camera_.model.height) {
    return std::nullopt;
  }
  SemanticCloud cloud;
  cloud.utime_us = image.utime_us;
  cloud.p_body_sensor = camera_.T_body_camera.translation();
  const Eigen::Vector3f origin = cloud.p_body_sensor.cast<float>();
  const auto unit = static_cast<float>(camera_.depth_unit), nearest = static_cast<float>(camera_.depth_min),
             farthest = static_cast<float>(farthest_);
  std::size_t k = 0;
  for (int y = 0; y < image.height; y += camera_.depth_stride) {
    for (int x = 0; x < image.width; x += camera_.depth_stride, ++k) {
      const std::uint16_t count = image.depth_mm[image.at(x, y)];
      const float depth = unit * static_cast<float>(count);
      if (count == 0 || depth < nearest || depth > farthest || rays_[k].isZero()) {
        continue;
      }
      const Eigen::Vector3f p = origin + depth * rays_[k];
      cloud.points.push_back({p.x(), p.y(), p.z(), 0, kUnknownClass});
    }
  }
  return cloud;
}

}  // namespace hgg
