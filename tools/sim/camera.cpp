#include "sim/camera.h"

#include <cmath>
#include <fstream>
#include <limits>

#include "core/units.h"

namespace hgg {
namespace {

/// Looks along the body's x turned by `yaw` (to the left) and then `down`.
Pose mount(const Vec3& position, double yaw, double down) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(down, Vec3::UnitY()) * cameraAxes();
  return pose;
}

CameraModel pinhole(const std::string& name, double width_deg, const Pose& T_body_camera) {
  CameraModel camera;
  camera.name = name;
  camera.fx = camera.fy = camera.width / 2.0 / std::tan(width_deg * kDegree / 2.0);
  camera.cx = (camera.width - 1) / 2.0, camera.cy = (camera.height - 1) / 2.0;
  camera.T_body_camera = T_body_camera;
  camera.errors = {.range_max = std::numeric_limits<double>::infinity(), .foliage_depth = 0.2};
  return camera;
}

/// The ray through a pixel, of length 1 along the optical axis.
Vec3 pixelRay(const CameraModel& camera, double x, double y) {
  return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0};
}

}  // namespace

Mat3 cameraAxes() {
  Mat3 R_body_camera;
  R_body_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R_body_camera;
}

CameraModel depthCamera() {
  CameraModel camera = pinhole("front", 70.0, mount(Vec3(0.1, 0.0, 0.0), 0.0, 10.0 * kDegree));
  camera.depth = true;
  camera.errors = {.range_min = 0.3,
                   .range_max = 8.0,
                   .noise = 0.001,
                   .noise_per_m2 = 0.0015,
                   .dropout = 0.01,
                   .grazing_deg = 8.0,
                   .foliage_depth = 0.2,
                   .mixed = 0.2};
  return camera;
}

std::vector<CameraModel> rigCameras(int count) {
  constexpr double kDown = 5.0 * kDegree;
  std::vector<CameraModel> cameras{pinhole("front", 90.0, mount(Vec3(0.15, 0.0, -0.10), 0.0, kDown)),
                                   pinhole("left", 90.0, mount(Vec3(0.0, 0.12, -0.10), 90.0 * kDegree, kDown)),
                                   pinhole("right", 90.0, mount(Vec3(0.0, -0.12, -0.10), -90.0 * kDegree, kDown))};
  cameras.resize(static_cast<std::size_t>(count));
  return cameras;
}

RayGrid cameraGrid(const CameraModel& camera) {
  RayGrid grid;
  grid.width = camera.width, grid.height = camera.height;
  grid.pitch_x_deg = std::atan(1.0 / camera.fx) / kDegree, grid.pitch_y_deg = std::atan(1.0 / camera.fy) / kDegree;
  grid.T_body_sensor = camera.T_body_camera;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      grid.directions.push_back(pixelRay(camera, x, y).normalized());
    }
  }
  return grid;
}

std::optional<Pixel> project(const CameraModel& camera, const Vec3& p_body) {
  const Vec3 p = camera.T_body_camera.inverse() * p_body;
  if (p.z() <= 0) {
    return std::nullopt;
  }
  const double x = std::round(camera.fx * p.x() / p.z() + camera.cx);
  const double y = std::round(camera.fy * p.y() / p.z() + camera.cy);
  if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) {
    return std::nullopt;
  }
  return Pixel{static_cast<int>(x), static_cast<int>(y)};
}

Vec3 unproject(const CameraModel& camera, const Pixel& pixel, double depth) {
  return camera.T_body_camera * (depth * pixelRay(camera, pixel.x, pixel.y));
}

DepthImage depthImage(const RayGrid& grid, const Scan& scan, Micros utime_us) {
  DepthImage image{utime_us, grid.width, grid.height, {}};
  image.depth_mm.reserve(grid.size());
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const double depth_mm = 1000.0 * scan.range[i] * grid.directions[i].z();
    image.depth_mm.push_back(depth_mm < 65535.0 ? static_cast<std::uint16_t>(std::lround(depth_mm)) : std::uint16_t{0});
  }
  return image;
}

std::string writeRig(const std::vector<CameraModel>& cameras, const std::string& path) {
  std::ofstream out(path);
  out.precision(17);
  out << "# Cameras of a simulated rig. T_body_camera: 3x4 rows; body x forward, z up; camera x right, y down, z "
         "forward.\n# Pixel (x, y) covers x-0.5 .. x+0.5.\n";
  for (const CameraModel& camera : cameras) {
    out << "\n[[camera]]\nname = \"" << camera.name << "\"\nlabels = \"CAMERA_LABELS_" << camera.name
        << "\"  # [channel] hgg.label_image_t\n";
    if (camera.depth) {
      out << "depth = \"DEPTH_" << camera.name << "\"  # [channel] bot_core.image_t, mm\n";
    }
    out << "width = " << camera.width << "  # [pixel]\nheight = " << camera.height << "\nfx = " << camera.fx
        << "\nfy = " << camera.fy << "\ncx = " << camera.cx << "\ncy = " << camera.cy << "\nT_body_camera = [";
    for (int i = 0; i < 12; ++i) {
      out << (i == 0 ? "" : ", ") << camera.T_body_camera.matrix()(i / 4, i % 4) + 0.0;
    }
    out << "]\n";
  }
  out.close();
  return out ? "" : "cannot write " + path;
}

}  // namespace hgg
