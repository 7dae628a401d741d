#include "frame/labelling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <vector>

#include "frame/image_cells.h"

namespace hgg {
namespace {

constexpr double kNear = 0.05;                       // m before the camera: nearer is inside its lens
constexpr int kSmallestCell = 2, kLargestCell = 16;  // pixels
constexpr float kBorderWeight = 0.5F;
constexpr std::uint32_t kCamerasPerInstance = 16;  // factor that keeps the instances of cameras apart
constexpr float kFar = std::numeric_limits<float>::infinity();

/// What the cameras say of a point: the two labels with the most weight.
struct Votes {
  std::array<Said, 2> said;
  std::array<float, 2> weight{0, 0};

  /// No class is no vote.
  void add(const Said& what, float w) {
    if (what.label == kUnknownClass) {
      return;
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (weight[k] > 0 && said[k].label == what.label) {
        weight[k] += w;
        return;
      }
    }
    const std::size_t k = weight[0] <= 0 ? 0 : 1;
    if (w > weight[k]) {
      said[k] = what, weight[k] = w;
    }
  }
  const Said& winner() const { return said[weight[1] > weight[0] ? 1 : 0]; }
};

/// Tangents of the image's edges, for a quick look whether a point can be in it; infinite for a fisheye.
struct Bounds {
  float x = kFar, y = kFar;
};

Bounds boundsOf(const CameraModel& camera) {
  if (camera.lens == Lens::kFisheye) {
    return {};
  }
  constexpr int kSteps = 16;
  constexpr double kRoom = 1.02;  // between the pixels that are looked at
  Bounds bounds{0, 0};
  for (int k = 0; k <= kSteps; ++k) {
    const double x = (camera.width * k) / static_cast<double>(kSteps) - 0.5,
                 y = (camera.height * k) / static_cast<double>(kSteps) - 0.5;
    for (const Vec3& ray : {pixelRay(camera, x, -0.5), pixelRay(camera, x, camera.height - 0.5),
                            pixelRay(camera, -0.5, y), pixelRay(camera, camera.width - 0.5, y)}) {
      bounds.x = std::max(bounds.x, static_cast<float>(kRoom * std::abs(ray.x())));
      bounds.y = std::max(bounds.y, static_cast<float>(kRoom * std::abs(ray.y())));
    }
  }
  return bounds;
}

std::vector<SeenPoint> projectAll(std::span<const Point> points, const LabelView& view) {
  const CameraModel& model = view.camera->model;
  const Projector project(model);
  const Bounds bounds = boundsOf(model);
  const bool is_fisheye = model.lens == Lens::kFisheye, is_ideal = isIdeal(model);
  const auto fx = static_cast<float>(model.fx), fy = static_cast<float>(model.fy), cx = static_cast<float>(model.cx),
             cy = static_cast<float>(model.cy);
  const float right = static_cast<float>(model.width) - 0.5F, low = static_cast<float>(model.height) - 0.5F;
  const Eigen::Matrix3f R = view.T_camera_body.linear().cast<float>();
  const Eigen::Vector3f t = view.T_camera_body.translation().cast<float>();
  std::vector<SeenPoint> seen;
  seen.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const float z = R(2, 0) * p.x + R(2, 1) * p.y + R(2, 2) * p.z + t.z();
    if (!is_fisheye && !(z > static_cast<float>(kNear))) {
      continue;
    }
    const float x = R(0, 0) * p.x + R(0, 1) * p.y + R(0, 2) * p.z + t.x();
    const float y = R(1, 0) * p.x + R(1, 1) * p.y + R(1, 2) * p.z + t.y();
    if (!is_fisheye && !(std::abs(x) <= z * bounds.x && std::abs(y) <= z * bounds.y)) {
      continue;
    }
    if (is_ideal) {
      const float u = fx * x / z + cx, v = fy * y / z + cy;
      constexpr auto half = static_cast<float>(kHalfPixel);
      if (u >= -half && v >= -half && u < right && v < low) {
        seen.push_back({static_cast<std::uint32_t>(i), z, static_cast<std::uint16_t>(u + half),
                        static_cast<std::uint16_t>(v + half)});
      }
      continue;
    }
    const Vec3 p_camera(x, y, z);
    const auto at = project(p_camera);
    if (!at || !(p_camera.squaredNorm() > kNear * kNear)) {
      continue;
    }
    const Pixel pixel = pixelAt(*at);
    seen.push_back({static_cast<std::uint32_t>(i), is_fisheye ? static_cast<float>(p_camera.norm()) : z,
                    static_cast<std::uint16_t>(pixel.x), static_cast<std::uint16_t>(pixel.y)});
  }
  return seen;
}

/// The pixels of an image, as the rig understands them.
class Pixels {
 public:
  Pixels(const LabelView& view, bool drop_cut_instances)
      : image_(*view.image),
        set_(view.camera->label_set),
        border_(bordersOf(*view.image, view.camera->margin)),
        camera_(static_cast<std::uint32_t>(view.number)) {
    if (drop_cut_instances && !image_.instances.empty()) {
      collectCutInstances();
    }
  }

  float confidence(std::size_t at) const {
    return image_.confidence.empty() ? 1.0F : static_cast<float>(image_.confidence[at]) / 255.0F;
  }
  std::int32_t classAt(std::size_t at) const { return set_.at(image_.labels[at]); }
  Said saidAt(std::size_t at, std::int32_t class_id) const {
    const std::uint32_t instance = image_.instances.empty() ? 0 : image_.instances[at];
    const bool is_none = instance == 0 || cut_.contains(instance);
    return {static_cast<ClassId>(class_id), is_none ? 0 : instance * kCamerasPerInstance + camera_};
  }

  /// Whether a pixel within the margin has another label or instance.
  bool isAtBorder(std::size_t at) const { return !border_.empty() && border_[at] != 0; }

 private:
  void collectCutInstances() {
    for (int x = 0; x < image_.width; ++x) {
      cut_.insert(image_.instances[image_.at(x, 0)]);
      cut_.insert(image_.instances[image_.at(x, image_.height - 1)]);
    }
    for (int y = 0; y < image_.height; ++y) {
      cut_.insert(image_.instances[image_.at(0, y)]);
      cut_.insert(image_.instances[image_.at(image_.width - 1, y)]);
    }
  }

  const LabelImage& image_;
  const LabelSet& set_;
  std::vector<std::uint8_t> border_;  // empty: there is no margin
  std::uint32_t camera_;
  std::unordered_set<std::uint32_t> cut_;
};

int cellSize(const CameraModel& camera, double beam_spacing) {
  const double pixels = std::ceil(std::max(camera.fx, camera.fy) * beam_spacing);
  return static_cast<int>(std::clamp<double>(pixels, kSmallestCell, kLargestCell));
}

/// A point of a view that is not decided at once.
struct Undecided {
  const SeenPoint* seen;
  Said own;
  float weight;
};

LabelCounts castVotes(std::span<const Point> points, const LabelView& view, bool drop_cut_instances,
                      const LabellingOptions& options, std::vector<Votes>& votes) {
  LabelCounts counts;
  const std::vector<SeenPoint> seen = projectAll(points, view);
  const int size = cellSize(view.camera->model, options.beam_spacing);
  const DepthCells cells(view.camera->model, size, view.baseline, seen);
  const Pixels pixels(view, drop_cut_instances);
  LabelDepths depths(view.camera->model, std::max(2 * size, view.camera->margin + 1));
  std::vector<Undecided> at_border;
  counts.seen += std::ssize(seen);
  for (const SeenPoint& s : seen) {
    const std::size_t at = view.image->at(s.x, s.y);
    if (cells.hides(s)) {
      ++counts.hidden;
      continue;
    }
    const float confidence = pixels.confidence(at);
    if (!(confidence >= static_cast<float>(options.min_confidence)) || confidence <= 0) {
      ++counts.unsure;
      continue;
    }
    const std::int32_t class_id = pixels.classAt(at);
    counts.foreign += class_id == LabelSet::kForeign ? 1 : 0;
    counts.no_class += class_id == kUnknownClass ? 1 : 0;
    const Said own = pixels.saidAt(at, class_id == LabelSet::kForeign ? kUnknownClass : class_id);
    if (pixels.isAtBorder(at)) {
      at_border.push_back({&s, own, kBorderWeight * confidence});
      depths.add(s, own, false);
      continue;
    }
    depths.add(s, own, true);
    votes[s.point].add(own, confidence);
  }
  counts.border += std::ssize(at_border);
  for (const Undecided& u : at_border) {
    const Said said = depths.judge(*u.seen, u.own);
    counts.regained += said.label != u.own.label ? 1 : 0;
    votes[u.seen->point].add(said, u.weight);
  }
  return counts;
}

}  // namespace

LabelReport labelPoints(std::span<Point> points, std::span<const LabelView> views, const LabellingOptions& options) {
  LabelReport report;
  std::vector<Votes> votes(points.size());
  for (const LabelView& view : views) {
    report.views.push_back(castVotes(points, view, views.size() > 1, options, votes));
    report.all += report.views.back();
  }
  report.all.points = std::ssize(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Said& said = votes[i].winner();
    points[i].label = said.label, points[i].instance = said.instance;
    report.all.labelled += said.label != kUnknownClass ? 1 : 0;
  }
  return report;
}

}  // namespace hgg
