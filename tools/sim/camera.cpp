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

SimCamera pinhole(const std::string& name, double width_deg, const Pose& T_body_camera) {
  SimCamera camera;
  camera.name = name;
  CameraModel& m = camera.model;
  m.fx = m.fy = m.width / 2.0 / std::tan(width_deg * kDegree / 2.0);
  m.cx = (m.width - 1) / 2.0, m.cy = (m.height - 1) / 2.0;
  camera.T_body_camera = T_body_camera;
  camera.errors = {.range_max = std::numeric_limits<double>::infinity(), .foliage_depth = 0.2};
  return camera;
}

}  // namespace

SimCamera depthCamera() {
  SimCamera camera = pinhole("front", 70.0, mount(Vec3(0.1, 0.0, 0.0), 0.0, 10.0 * kDegree));
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

std::vector<SimCamera> rigCameras(int count) {
  constexpr double kDown = 5.0 * kDegree;
  std::vector<SimCamera> cameras{pinhole("front", 90.0, mount(Vec3(0.15, 0.0, -0.10), 0.0, kDown)),
                                 pinhole("left", 90.0, mount(Vec3(0.0, 0.12, -0.10), 90.0 * kDegree, kDown)),
                                 pinhole("right", 90.0, mount(Vec3(0.0, -0.12, -0.10), -90.0 * kDegree, kDown))};
  cameras.resize(static_cast<std::size_t>(count));
  return cameras;
}

RayGrid cameraGrid(const SimCamera& camera) {
  const CameraModel& m = camera.model;
  RayGrid grid;
  grid.width = m.width, grid.height = m.height;
  grid.pitch_x_deg = std::atan(1.0 / m.fx) / kDegree, grid.pitch_y_deg = std::atan(1.0 / m.fy) / kDegree;
  grid.T_body_sensor = camera.T_body_camera;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      grid.directions.push_back(pixelRay(m, x, y).normalized());
    }
  }
  return grid;
}

std::optional<Pixel> project(const SimCamera& camera, const Vec3& p_body) {
  const auto at = Projector(camera.model)(camera.T_body_camera.inverse() * p_body);
  return at ? std::optional(pixelAt(*at)) : std::nullopt;
}

Vec3 unproject(const SimCamera& camera, const Pixel& pixel, double depth) {
  return camera.T_body_camera * (depth * pixelRay(camera.model, pixel.x, pixel.y));
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

std::string writeRig(const std::vector<SimCamera>& cameras, bool has_lidar, const std::string& path) {
  std::ofstream out(path);
  out.precision(17);
  out << "# A simulated rig (docs/rig.md). T_body_...: 3x4 rows; body x forward, z up; camera x right, y down, z "
         "forward.\n# Pixel (x, y) covers x-0.5 .. x+0.5.\n";
  if (has_lidar) {
    out << "\n[[lidar]]\nname = \"lidar\"\nchannel = \"LIDAR\"  # bot_core.pointcloud2_t\n"
           "T_body_lidar = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\n";
  }
  for (const SimCamera& camera : cameras) {
    out << "\n[[camera]]\nname = \"" << camera.name << "\"\nlabels = \"CAMERA_LABELS_" << camera.name
        << "\"  # [channel] hgg.label_image_t\n";
    if (camera.depth) {
      out << "depth = \"DEPTH_" << camera.name << "\"  # [channel] bot_core.image_t, mm\n";
    }
    const CameraModel& m = camera.model;
    out << "width = " << m.width << "  # [pixel]\nheight = " << m.height << "\nfx = " << m.fx << "\nfy = " << m.fy
        << "\ncx = " << m.cx << "\ncy = " << m.cy << "\nT_body_camera = [";
    for (int i = 0; i < 12; ++i) {
      out << (i == 0 ? "" : ", ") << camera.T_body_camera.matrix()(i / 4, i % 4) + 0.0;
    }
    out << "]\n";
  }
  out.close();
  return out ? "" : "cannot write " + path;
}

}  // namespace hgg
