#include "convert/label_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include "bus/codec.h"
#include "bus/log.h"
#include "core/toml_text.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr int kFill = 6;                       // pixels between beams, at most
constexpr float kStep = 0.3F, kSlope = 0.05F;  // m, and per m: what is nearer by more is another surface
constexpr float kFar = std::numeric_limits<float>::infinity();

/// An image in the making.
struct Canvas {
  LabelImage image;
  std::vector<float> depth;  // m along the optical axis; kFar: nothing is seen
};

void set(Canvas& canvas, std::size_t at, const Canvas& from, std::size_t source) {
  canvas.image.labels[at] = from.image.labels[source];
  canvas.image.instances[at] = from.image.instances[source];
  canvas.depth[at] = from.depth[source];
}

Canvas paintPoints(const RigCamera& camera, const std::vector<Point>& points) {
  const Projector project(camera.model);
  const Pose T_camera_body = camera.T_body_camera.inverse();
  Canvas canvas;
  canvas.image.width = camera.model.width, canvas.image.height = camera.model.height;
  const auto pixels = static_cast<std::size_t>(camera.model.width) * static_cast<std::size_t>(camera.model.height);
  canvas.image.labels.resize(pixels), canvas.image.instances.resize(pixels), canvas.depth.resize(pixels, kFar);
  for (const Point& p : points) {
    const Vec3 p_camera = T_camera_body * Vec3(p.x, p.y, p.z);
    const auto seen = project(p_camera);
    if (!seen) {
      continue;
    }
    const Pixel pixel = pixelAt(*seen);
    const std::size_t at = canvas.image.at(pixel.x, pixel.y);
    if (static_cast<float>(p_camera.z()) < canvas.depth[at]) {
      canvas.depth[at] = static_cast<float>(p_camera.z());
      canvas.image.labels[at] = p.label, canvas.image.instances[at] = p.instance;
    }
  }
  return canvas;
}

/// Calls `visit` for each pixel of the image up to `reach` away from (x, y).
template <typename Visit>
void around(const LabelImage& image, int x, int y, int reach, Visit visit) {
  for (int v = std::max(y - reach, 0); v <= std::min(y + reach, image.height - 1); ++v) {
    for (int u = std::max(x - reach, 0); u <= std::min(x + reach, image.width - 1); ++u) {
      visit(image.at(u, v), (u - x) * (u - x) + (v - y) * (v - y));
    }
  }
}

/// Each pixel where nothing is seen gets what the nearest one has.
Canvas fill(const Canvas& from) {
  Canvas out = from;
  for (int y = 0; y < from.image.height; ++y) {
    for (int x = 0; x < from.image.width; ++x) {
      const std::size_t at = from.image.at(x, y);
      if (from.depth[at] < kFar) {
        continue;
      }
      int least = kFill * kFill + 1;
      around(from.image, x, y, kFill, [&](std::size_t there, int square) {
        if (from.depth[there] < kFar && square < least) {
          least = square;
          set(out, at, from, there);
        }
      });
    }
  }
  return out;
}

/// Whether a SemanticKITTI label is that of ground: road, parking, sidewalk, other ground, lane marking, terrain.
bool isGround(ClassId label) {
  constexpr std::array<ClassId, 6> kGround = {40, 44, 48, 49, 60, 72};
  return std::ranges::find(kGround, label) != kGround.end();
}

/// What is nearer grows over what is behind it. Not the ground, which things stand on and do not hide behind: seen at a
/// slant it looks nearer than their feet.
Canvas bleedOver(const Canvas& from, int reach) {
  Canvas out = from;
  for (int y = 0; y < from.image.height; ++y) {
    for (int x = 0; x < from.image.width; ++x) {
      const std::size_t at = from.image.at(x, y);
      around(from.image, x, y, reach, [&](std::size_t there, int square) {
        const bool is_nearer =
            !isGround(from.image.labels[there]) && (1 + kSlope) * from.depth[there] + kStep < from.depth[at];
        if (square <= reach * reach && is_nearer && from.depth[there] < out.depth[at]) {
          set(out, at, from, there);
        }
      });
    }
  }
  return out;
}

RigCamera virtualCamera(const std::string& name, double yaw) {
  RigCamera camera;
  camera.name = name;
  camera.labels = "CAMERA_LABELS_" + name;
  CameraModel& m = camera.model;
  m.width = 640, m.height = 264;
  m.fx = m.fy = m.width / 2.0 / std::tan(50 * kDegree);
  m.cx = (m.width - 1) / 2.0, m.cy = 55;  // the LiDAR looks down by 25 degrees and up by 3
  const Mat3 R_body_side = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  camera.T_body_camera.linear() = R_body_side * cameraAxes();
  camera.T_body_camera.translation() = R_body_side * Vec3(0.27, 0, -0.08);
  return camera;
}

std::string numbers(const Pose& T) {
  std::string text;
  for (Eigen::Index k = 0; k < 12; ++k) {
    const double v = T.matrix()(k / 4, k % 4);
    text += (k == 0 ? "" : ", ") + tomlFloat(std::abs(v) < 1e-15 ? 0.0 : v);
  }
  return "[" + text + "]";
}

}  // namespace

Rig virtualRig() {
  Rig rig;
  rig.lidars.push_back({"lidar", "LIDAR"});
  rig.cameras = {virtualCamera("front", 0), virtualCamera("left", 90 * kDegree), virtualCamera("back", 180 * kDegree),
                 virtualCamera("right", -90 * kDegree)};
  return rig;
}

LabelImage paintLabels(const RigCamera& camera, const std::vector<Point>& points, int bleed) {
  LabelImage image = bleedOver(fill(paintPoints(camera, points)), bleed).image;
  if (std::ranges::all_of(image.instances, [](std::uint32_t id) { return id == 0; })) {
    image.instances.clear();
  }
  return image;
}

std::string writeRigFile(const Rig& rig, const std::string& about, const std::filesystem::path& path) {
  std::ofstream out(path);
  out << about;
  for (const RigLidar& lidar : rig.lidars) {
    out << "\n[[lidar]]\nname = " << tomlString(lidar.name) << "\nchannel = " << tomlString(lidar.channel)
        << "  # bot_core.pointcloud2_t without labels\nT_body_lidar = " << numbers(lidar.T_body_lidar) << "\n";
  }
  for (const RigCamera& camera : rig.cameras) {
    const CameraModel& m = camera.model;
    out << "\n[[camera]]\nname = " << tomlString(camera.name) << "\nlabels = " << tomlString(camera.labels)
        << "  # hgg.label_image_t\nwidth = " << m.width << "\nheight = " << m.height << "\nfx = " << tomlFloat(m.fx)
        << "\nfy = " << tomlFloat(m.fy) << "\ncx = " << tomlFloat(m.cx) << "\ncy = " << tomlFloat(m.cy)
        << "\nT_body_camera = " << numbers(camera.T_body_camera) << "\n";
  }
  out.close();
  return out ? "" : "cannot write " + path.string();
}

std::string convertKittiToRig(const std::vector<KittiFrame>& frames, int bleed, const std::filesystem::path& log,
                              const Progress& progress) {
  auto writer = LogWriter::create(log.string());
  if (!writer) {
    return writer.error;
  }
  const Rig rig = virtualRig();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto points = readKittiPoints(frames[i]);
    if (!points) {
      return points.error;
    }
    const Micros utime_us = frames[i].utime_us;
    std::string error = writer->write("POSE_ODOM", utime_us, encodePose(utime_us, frames[i].T_world_body));
    for (const RigCamera& camera : rig.cameras) {
      LabelImage image = paintLabels(camera, *points, bleed);
      image.utime_us = utime_us;
      error = error.empty() ? writer->write(camera.labels, utime_us, encodeLabelImage(image)) : error;
    }
    error = error.empty() ? writer->write("LIDAR", utime_us, encodeCloud(utime_us, *points)) : error;
    if (!error.empty()) {
      return error;
    }
    progress(i + 1, frames.size());
  }
  const std::string error = writer->close();
  return error.empty()
             ? writeRigFile(rig,
                            "# A LiDAR and four virtual cameras around it, as hgg-convert writes them (docs/rig.md).\n",
                            log.parent_path() / (log.stem().string() + ".rig.toml"))
             : error;
}

}  // namespace hgg
