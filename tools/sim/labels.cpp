#include "sim/labels.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

constexpr int kClump = 4;  // pixels: border errors come in squares of this edge
constexpr ClassId kUnknown = 0;

struct Offset {
  int x = 0, y = 0;
  double angle_deg = 0;
};

/// Neighbours within `reach_deg`, the nearest first.
std::vector<Offset> neighbours(const RayGrid& grid, double reach_deg) {
  std::vector<Offset> offsets;
  const auto cells = [&](double pitch_deg) { return pitch_deg > 0 ? static_cast<int>(reach_deg / pitch_deg) : 0; };
  const int reach_x = cells(grid.pitch_x_deg), reach_y = cells(grid.pitch_y_deg);
  for (int y = -reach_y; y <= reach_y; ++y) {
    for (int x = -reach_x; x <= reach_x; ++x) {
      const double angle_deg = std::hypot(x * grid.pitch_x_deg, y * grid.pitch_y_deg);
      if ((x != 0 || y != 0) && angle_deg <= reach_deg) {
        offsets.push_back({x, y, angle_deg});
      }
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const Offset& a, const Offset& b) { return a.angle_deg < b.angle_deg; });
  return offsets;
}

/// The nearest other object beside a pixel; -1 when there is none.
std::int32_t objectBeside(const RayGrid& grid, const Scan& scan, const std::vector<Offset>& offsets, int x, int y) {
  const std::int32_t own = scan.object[grid.at(x, y)];
  for (const Offset& offset : offsets) {
    const int nx = grid.wraps ? (x + offset.x + grid.width) % grid.width : x + offset.x, ny = y + offset.y;
    if (nx < 0 || nx >= grid.width || ny < 0 || ny >= grid.height) {
      continue;
    }
    const std::int32_t other = scan.object[grid.at(nx, ny)];
    if (other >= 0 && other != own) {
      return other;
    }
  }
  return -1;
}

/// Another class of the palette than `label`, drawn by u in (0, 1); unknown when there is none.
ClassId otherClass(const std::vector<ClassId>& palette, ClassId label, double u) {
  const auto count =
      static_cast<double>(palette.size() - static_cast<std::size_t>(std::count(palette.begin(), palette.end(), label)));
  auto left = static_cast<std::size_t>(u * count);
  for (const ClassId other : palette) {
    if (other != label && left-- == 0) {
      return other;
    }
  }
  return kUnknown;
}

/// One image in the making.
struct Painter {
  const Segmentation& segmentation;
  const RayGrid& grid;
  const Scan& scan;
  const std::vector<ClassId>& object_labels;
  RandomKey key;
  std::vector<Offset> offsets;
  const FrameMistakes& mistakes;

  enum Use : std::uint64_t { kKind, kClass, kConfidence, kBleed };
  double draw(Use use, std::size_t i) const { return uniform(key, 4 * i + use); }

  /// The object whose label a pixel gets: its own or, where labels bleed, that beside it.
  std::int32_t source(int x, int y) const {
    const std::size_t clump = grid.at(x - x % kClump, y - y % kClump);
    const bool bleeds = draw(kBleed, clump) < segmentation.errors.bleed;
    const std::int32_t beside = bleeds ? objectBeside(grid, scan, offsets, x, y) : -1;
    return beside >= 0 ? beside : scan.object[grid.at(x, y)];
  }

  /// What an object is taken for at pixel `i` in column `x`.
  ClassId nameOf(std::size_t object, int x, std::size_t i) const {
    if (!mistakes.patches.empty() && !scan.true_range.empty() && scan.true_range[i] > 0) {
      const Vec3 p = static_cast<double>(scan.true_range[i]) * grid.directions[i];
      if (const auto label = mistakes.at(object, x, p)) {
        return *label;
      }
    }
    return object_labels[object];
  }

  std::uint8_t confidence(bool right, std::size_t i) const {
    const double u = draw(kConfidence, i);
    return static_cast<std::uint8_t>(std::lround(255.0 * (right ? 0.7 + 0.3 * u : 0.3 + 0.6 * u)));
  }

  void paint(LabelImage& image, int x, int y) const {
    const std::size_t i = grid.at(x, y);
    if (scan.object[i] < 0) {
      return;
    }
    const LabelErrors& errors = segmentation.errors;
    const WorldObject& object = segmentation.world->objects[static_cast<std::size_t>(source(x, y))];
    const ClassId truth = segmentation.world->objects[static_cast<std::size_t>(scan.object[i])].label;
    image.labels[i] = nameOf(object.id - 1, x, i);
    const double kind = draw(kKind, i);
    const bool is_speckle = kind < errors.speckle + errors.unknown;
    if (is_speckle) {
      image.labels[i] = kind < errors.speckle ? otherClass(segmentation.palette, truth, draw(kClass, i)) : kUnknown;
    }
    if (segmentation.instances && object.thing && !is_speckle && image.labels[i] != kUnknown) {
      image.instances[i] = object.id;
    }
    image.confidence[i] = confidence(image.labels[i] == truth, i);
  }
};

}  // namespace

std::optional<LabelErrors> labelPreset(const std::string& name, Segmented what) {
  const bool image = what == Segmented::kImage;
  if (name == "perfect") {
    return LabelErrors{};
  }
  if (name == "good") {
    return LabelErrors{.speckle = 0.01,
                       .unknown = 0.01,
                       .bleed = image ? 0.25 : 0.1,
                       .bleed_deg = image ? 0.7 : 0.5,
                       .confused = 0.02,
                       .missed = 0.02,
                       .mixed = 0.5,
                       .stretch_frames = 10};
  }
  if (name == "poor") {
    return LabelErrors{.speckle = 0.05,
                       .unknown = 0.04,
                       .bleed = image ? 0.5 : 0.25,
                       .bleed_deg = image ? 1.2 : 0.8,
                       .confused = 0.10,
                       .missed = 0.08,
                       .mixed = 1.0,
                       .stretch_frames = 15};
  }
  return std::nullopt;
}

std::vector<ClassId> objectLabels(const World& world, const LabelErrors& errors, std::uint64_t seed,
                                  std::size_t frame) {
  std::vector<ClassId> labels;
  const auto length = static_cast<double>(std::max(errors.stretch_frames, 1));
  for (const WorldObject& object : world.objects) {
    const RandomKey key = keyFor(seed, Purpose::kObjectLabels, 0, object.id);
    const double phase = uniform(key, 0) * length;
    const auto stretch = static_cast<std::uint64_t>((static_cast<double>(frame) + phase) / length);
    const double u = uniform(key, 1 + stretch);
    const bool confusable = object.confused_with != 0 && object.confused_with != object.label;
    const double confused = confusable ? errors.confused : 0.0, missed = object.thing ? errors.missed : 0.0;
    labels.push_back(u < confused ? object.confused_with : u < confused + missed ? kUnknown : object.label);
  }
  return labels;
}

std::vector<ClassId> worldLabels(const World& world) {
  std::vector<ClassId> labels;
  for (const WorldObject& object : world.objects) {
    labels.push_back(object.label);
  }
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return labels;
}

LabelImage segment(const Segmentation& segmentation, const RayGrid& grid, const Scan& scan,
                   const std::vector<ClassId>& object_labels, const RandomKey& key, int threads,
                   const FrameMistakes& mistakes) {
  LabelImage image;
  image.width = grid.width, image.height = grid.height;
  image.labels.assign(grid.size(), kUnknown);
  if (segmentation.instances) {
    image.instances.assign(grid.size(), 0);
  }
  image.confidence.assign(grid.size(), 0);
  const Painter painter{segmentation, grid, scan, object_labels, key, neighbours(grid, segmentation.errors.bleed_deg),
                        mistakes};
  parallelFor(grid.height, threads, [&](int y) {
    for (int x = 0; x < grid.width; ++x) {
      painter.paint(image, x, y);
    }
  });
  return image;
}

}  // namespace hgg
