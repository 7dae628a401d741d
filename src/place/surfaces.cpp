#include "place/surfaces.h"

#include <algorithm>
#include <cmath>

namespace hgg {
namespace {

constexpr double kFarthest = 1e15;  // cells

}  // namespace

SurfaceIndex::SurfaceIndex(std::span<const Surface> surfaces, double radius) : radius_(radius) {
  for (std::size_t i = 0; radius > 0 && i < surfaces.size(); ++i) {
    cells_[keyOf(surfaces[i].mean, 0, 0, 0)].push_back({surfaces[i].mean, i});
  }
}

void SurfaceIndex::near(const Vec3& p, std::vector<std::size_t>& found) const {
  found.clear();
  if (cells_.empty()) {
    return;
  }
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dz = -1; dz <= 1; ++dz) {
        const auto cell = cells_.find(keyOf(p, dx, dy, dz));
        if (cell == cells_.end()) {
          continue;
        }
        for (const Entry& entry : cell->second) {
          if ((entry.mean - p).squaredNorm() < radius_ * radius_) {
            found.push_back(entry.index);
          }
        }
      }
    }
  }
}

/// 21 bits an axis, modulo: what shares a cell from two million cells away is told apart by its distance.
std::uint64_t SurfaceIndex::keyOf(const Vec3& p, int dx, int dy, int dz) const {
  const auto bits = [this](double x, int d) {
    const double cell = std::floor(x / radius_);
    const double inside = cell > -kFarthest ? std::min(cell, kFarthest) : -kFarthest;  // what is no number, too
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(inside) + d) & 0x1fffffU;
  };
  return bits(p.x(), dx) << 42U | bits(p.y(), dy) << 21U | bits(p.z(), dz);
}

}  // namespace hgg
