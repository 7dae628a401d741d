#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/classes.h"
#include "frame/camera.h"
#include "frame/image.h"

namespace hgg {

/// A point in an image.
struct SeenPoint {
  std::uint32_t point = 0;  // its number in the cloud
  float z = 0;              // m along the optical axis; of a fisheye: from the camera
  std::uint16_t x = 0, y = 0;
};

/// What a pixel says.
struct Said {
  ClassId label = kUnknownClass;
  std::uint32_t instance = 0;
  bool operator==(const Said&) const = default;
};

/// An image in square cells, with a rim of empty ones around it, so that neighbours need no bounds.
class CellGrid {
 public:
  static constexpr int kRim = 2;
  CellGrid(const CameraModel& camera, int size)
      : size_(size),
        columns_((camera.width + size - 1) / size + 2 * kRim),
        rows_((camera.height + size - 1) / size + 2 * kRim) {}

  std::size_t cellOf(const SeenPoint& s) const {
    return static_cast<std::size_t>(s.y / size_ + kRim) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(s.x / size_ + kRim);
  }
  std::ptrdiff_t columns() const { return columns_; }
  std::size_t count() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }

 private:
  int size_, columns_, rows_;
};

/// The nearest point of each cell, with cells as wide as beams are apart.
class DepthCells {
 public:
  /// `baseline`: m between the camera and where the points were measured from.
  DepthCells(const CameraModel& camera, int size, double baseline, std::span<const SeenPoint> seen);
  /// Whether there is something nearer on each side of a point, and so much nearer that from the camera it may cover
  /// what the sensor saw past it: by a pixel, by the parallax between the two. Never so on a surface that is seen at a
  /// slant: what is nearer is then on one side only.
  bool hides(const SeenPoint& s) const;

 private:
  float towards(std::size_t at, std::ptrdiff_t step, std::ptrdiff_t across) const;

  CellGrid grid_;
  float parallax_ = 0;  // pixels between what is 1 m away and what is infinitely far
  std::vector<float> nearest_;
};

/// How far away the points are that a label is said of, by cell; those well inside a mask apart from those near its
/// border. Cells are wider than the margin.
class LabelDepths {
 public:
  LabelDepths(const CameraModel& camera, int size) : grid_(camera, size), cells_(grid_.count()) {}
  void add(const SeenPoint& s, const Said& said, bool is_inside);
  /// What a point near the border of a mask is, whose pixel says `own`. That stands where points well inside the mask
  /// are as far away as it is; and where nothing speaks against it, for things may be thinner than the margin. Against
  /// it speaks that the label is said of something nearer too, over whose edge it may have bled, or that what lies
  /// inside the mask is behind the point. Then it is the label whose points are as far away as it is, well inside their
  /// mask, else near its border; none where there is no such label.
  Said judge(const SeenPoint& s, const Said& own) const;

 private:
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  struct Entry {
    Said said;
    float nearest = kNone, farthest = -kNone;  // of all points; kNone: the entry is empty
    float inside_nearest = kNone, inside_farthest = -kNone;
  };

  CellGrid grid_;
  std::vector<std::array<Entry, 3>> cells_;
};

/// The pixels that have another label or instance within `margin` of them, 1 each; empty without a margin.
std::vector<std::uint8_t> bordersOf(const LabelImage& image, int margin);

}  // namespace hgg
