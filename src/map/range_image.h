#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/types.h"

namespace hgg {

/// How the beams of a frame met a soft footprint: those that would have hit what is there, in beams.
struct BeamCount {
  double through = 0;  // ended clearly behind it
  double hits = 0;     // ended in it
  double hidden = 0;   // ended before it
  double ends = 0;     // ended about where it is, each by how near to its middle, whatever the chance of a hit was
};

/// Where the beams of one frame ended, whatever they hit: the number of beams and the nearest end of each bin of the
/// four upright faces of a cube about the sensor. Bins are half a degree wide in the middle of a face and smaller at
/// its rims; what is steeper than 51 degrees in the middle of a face (38 at its rims) is left out. Beams are counted,
/// not bins, so the image needs no more than that to serve a dense sensor as well as a sparse one.
class RangeImage {
 public:
  explicit RangeImage(const Vec3& p_body_sensor);

  /// Adds the end of a beam, body frame. One that is not finite is left out.
  void add(float x, float y, float z) {
    const float dx = x - sensor_[0], dy = y - sensor_[1], dz = z - sensor_[2];
    const float ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
    const bool along_x = ax >= ay;
    const float a = along_x ? ax : ay;
    // Face 0 looks along x, 1 along -x, 2 along y, 3 along -y; `b` grows to the left of each.
    const unsigned face = along_x ? (dx < 0 ? 1U : 0U) : (dy < 0 ? 3U : 2U);
    const float b = along_x ? (dx < 0 ? -dy : dy) : (dy < 0 ? dx : -dx);
    const float per_bin = kBinsPerUnit / a, v = dz * per_bin + kHalfRows;
    if (!(a > kNearest && a < kFarthest && v >= 0 && v < kRows && b <= a)) {  // also when one is not a number
      return;
    }
    const auto row = static_cast<unsigned>(v);
    const auto column = std::min(static_cast<unsigned>(std::max(b * per_bin + kBinsPerUnit, 0.0F)), kColumns - 1U);
    Bin& bin = bins_[(face * kRows + row) * kColumns + column];
    const auto depth = static_cast<std::uint16_t>(a * kUnitsPerMetre);
    bin.nearest = std::min(bin.nearest, depth);
    bin.beams = static_cast<std::uint16_t>(bin.beams + (bin.beams < 0xFFFF ? 1 : 0));
  }

  /// The beams that would have hit a thing of the Gaussian extent (mean, cov) about the sensor (axes of the body), were
  /// it there: each counts as the chance of that, where `sigma` (m) is how well frame and thing lie to each other. A
  /// beam beside a thin pole counts little for that reason. A bin with an end before the thing is hidden,
  /// whatever else is in it; one without ends says nothing.
  BeamCount beamsAt(const Vec3& p_sensor, const Mat3& cov, double sigma) const;

 private:
  struct Bin {
    std::uint16_t nearest = 0xFFFF;  // along the face's axis
    std::uint16_t beams = 0;
  };
  static constexpr float kBinsPerUnit = 128;                 // bins for a slope of one
  static constexpr float kHalfRows = 160;                    // slopes up to 1.25
  static constexpr int kRows = 320, kColumns = 256;          // of a face
  static constexpr float kUnitsPerMetre = 200;               // depths to 5 mm
  static constexpr float kNearest = 0.05F, kFarthest = 320;  // m; what 16 bits hold

  std::array<float, 3> sensor_;
  std::vector<Bin> bins_;
};

}  // namespace hgg
