#include "frame/image_cells.h"

#include <algorithm>

namespace hgg {
namespace {

constexpr float kStep = 0.3F, kSlope = 0.05F;  // m, and per m: what is behind by less may be the same surface
constexpr float kOtherSlope = 0.02F;           // per m: as far away as points of another label

bool isNearer(float a, float b) { return (1 + kSlope) * a + kStep < b; }

/// Marks the pixels that have another value than the one at `offset` from them, and those.
template <typename T>
void markSteps(const std::vector<T>& values, std::size_t from, std::size_t count, std::size_t offset,
               std::vector<std::uint8_t>& marks) {
  for (std::size_t i = from; i < from + count; ++i) {
    const auto differs = static_cast<std::uint8_t>(values[i] != values[i + offset]);
    marks[i] |= differs;
    marks[i + offset] |= differs;
  }
}

template <typename T>
void markSteps(const std::vector<T>& values, const LabelImage& image, std::vector<std::uint8_t>& marks) {
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  for (std::size_t y = 0; y < height && !values.empty(); ++y) {
    markSteps(values, y * width, width - 1, 1, marks);
    if (y + 1 < height) {
      markSteps(values, y * width, width, width, marks);
    }
  }
}

/// What is marked grows by a pixel to all sides.
void grow(std::vector<std::uint8_t>& marks, std::size_t width, std::size_t height) {
  std::vector<std::uint8_t> wide = marks;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t i = y * width + 1; i < (y + 1) * width; ++i) {
      wide[i] |= marks[i - 1];
      wide[i - 1] |= marks[i];
    }
  }
  marks = wide;
  for (std::size_t i = width; i < width * height; ++i) {
    marks[i] |= wide[i - width];
    marks[i - width] |= wide[i];
  }
}

}  // namespace

DepthCells::DepthCells(const CameraModel& camera, int size, double baseline, std::span<const SeenPoint> seen)
    : grid_(camera, size),
      parallax_(static_cast<float>(std::max(camera.fx, camera.fy) * baseline)),
      nearest_(grid_.count(), std::numeric_limits<float>::infinity()) {
  for (const SeenPoint& s : seen) {
    float& at = nearest_[grid_.cellOf(s)];
    at = std::min(at, s.z);
  }
}

bool DepthCells::hides(const SeenPoint& s) const {
  const float by_parallax = parallax_ * s.z / (parallax_ + s.z);  // 1 / nearer = 1 / z + 1 pixel / parallax
  const float limit = std::min((s.z - kStep) / (1 + kSlope), by_parallax);
  const std::size_t at = grid_.cellOf(s);
  const std::ptrdiff_t row = grid_.columns();
  return towards(at, -row, 1) < limit && towards(at, row, 1) < limit && towards(at, -1, row) < limit &&
         towards(at, 1, row) < limit;
}

/// The nearest in the three cells beside `at` in direction `step`, and in the one behind them.
float DepthCells::towards(std::size_t at, std::ptrdiff_t step, std::ptrdiff_t across) const {
  const float* const here = nearest_.data() + at;
  return std::min(std::min(here[step], here[step - across]), std::min(here[step + across], here[2 * step]));
}

void LabelDepths::add(const SeenPoint& s, const Said& said, bool is_inside) {
  for (Entry& entry : cells_[grid_.cellOf(s)]) {
    if (entry.nearest < kNone && !(entry.said == said)) {
      continue;
    }
    entry.said = said;
    entry.nearest = std::min(entry.nearest, s.z), entry.farthest = std::max(entry.farthest, s.z);
    if (is_inside) {
      entry.inside_nearest = std::min(entry.inside_nearest, s.z);
      entry.inside_farthest = std::max(entry.inside_farthest, s.z);
    }
    return;
  }
}

Said LabelDepths::judge(const SeenPoint& s, const Said& own) const {
  const float tolerance = kStep + kSlope * s.z;
  Said inside, border;
  float least_inside = kStep + kOtherSlope * s.z, least_border = least_inside;
  bool is_refuted = false;
  const auto at = static_cast<std::ptrdiff_t>(grid_.cellOf(s));
  for (std::ptrdiff_t y = -1; y <= 1; ++y) {
    for (std::ptrdiff_t x = -1; x <= 1; ++x) {
      for (const Entry& entry : cells_[static_cast<std::size_t>(at + y * grid_.columns() + x)]) {
        if (!(entry.nearest < kNone)) {
          break;
        }
        const float off = std::max({entry.inside_nearest - s.z, s.z - entry.inside_farthest, 0.0F});
        if (entry.said == own) {
          if (off <= tolerance) {
            return own;
          }
          is_refuted |= isNearer(entry.nearest, s.z) || off < kNone;
          continue;
        }
        if (off < least_inside) {
          least_inside = off, inside = entry.said;
        }
        const float off_border = std::max({entry.nearest - s.z, s.z - entry.farthest, 0.0F});
        if (off_border < least_border) {
          least_border = off_border, border = entry.said;
        }
      }
    }
  }
  return !is_refuted ? own : inside.label != kUnknownClass ? inside : border;
}

std::vector<std::uint8_t> bordersOf(const LabelImage& image, int margin) {
  if (margin == 0) {
    return {};
  }
  std::vector<std::uint8_t> marks(image.labels.size(), 0);
  markSteps(image.labels, image, marks);
  markSteps(image.instances, image, marks);
  for (int k = 1; k < margin; ++k) {
    grow(marks, static_cast<std::size_t>(image.width), static_cast<std::size_t>(image.height));
  }
  return marks;
}

}  // namespace hgg
