#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>

#include "core/result.h"
#include "traversability/cost_grid.h"

namespace hgg {

/// Index of a voxel: it spans resolution * (x, y, z) to resolution * (x + 1, y + 1, z + 1) of the map frame.
using Voxel = std::array<std::int32_t, 3>;

/// Log-odds of occupancy, sparse: bricks of 8 x 8 x 8 voxels.
class VoxelGrid {
 public:
  static constexpr std::int32_t kEdge = 8;
  static constexpr float kUnknown = std::numeric_limits<float>::infinity();
  using Brick = std::array<float, static_cast<std::size_t>(kEdge* kEdge* kEdge)>;

  explicit VoxelGrid(double resolution) : resolution_(resolution) {}

  double resolution() const { return resolution_; }
  Voxel voxelOf(const Vec3& p_map) const {
    const auto index = [&](double v) { return static_cast<std::int32_t>(std::floor(v / resolution_)); };
    return {index(p_map.x()), index(p_map.y()), index(p_map.z())};
  }
  Vec3 centreOf(const Voxel& v) const { return resolution_ * Vec3(v[0] + 0.5, v[1] + 0.5, v[2] + 0.5); }
  /// kUnknown where nothing was set.
  float& at(const Voxel& v);
  std::size_t bricks() const { return bricks_.size(); }
  /// The class of what fills a voxel, where classes were asked for (VoxelOptions::classes); 0 else.
  ClassId labelOf(const Voxel& v) const;
  void setLabel(const Voxel& v, ClassId label);
  /// Calls visit(voxel, log_odds) for every voxel that is known, in ascending order of bricks and of voxels in them.
  template <typename Visit>
  void forEach(Visit visit) const;

 private:
  std::vector<std::uint64_t> sortedBricks() const;

  static std::uint64_t keyOf(const Voxel& v);
  static std::size_t insideOf(const Voxel& v);

  double resolution_;
  std::unordered_map<std::uint64_t, Brick> bricks_;
  std::unordered_map<std::uint64_t, std::array<ClassId, std::tuple_size_v<Brick>>> labels_;
  std::uint64_t last_key_ = ~std::uint64_t{0};
  Brick* last_ = nullptr;  // rays and sheets stay in a brick for many voxels
};

struct VoxelOptions {
  double resolution = 0.1;                          // m
  std::optional<GridRegion> region = std::nullopt;  // all of the map
  double most_samples = 2e9;                        // more are refused; these take some minutes
  bool classes = false;                             // note which class fills a voxel
};

/// Occupancy out of the leaves: every sheet that enough points speak for is a hit in the voxels it runs through,
/// weighted by its points; free space is cast from keyframes that observed a node to its sheets, and ends at the first
/// surface on the way: a beam did not go through it. The leaves must be in memory. An error for a resolution out of
/// range or more voxels than memory should hold.
Result<VoxelGrid> voxelsOf(const MapLeaves& map, const VoxelOptions& options, const ShareDone& progress = nullptr);

constexpr std::int32_t kVoxelOffset = 1 << 20;  // brick indices within +- this many, packed into 21 bits each

template <typename Visit>
void VoxelGrid::forEach(Visit visit) const {
  for (const std::uint64_t key : sortedBricks()) {
    const Brick& brick = bricks_.at(key);
    const auto axis = [&](int shift) {
      return (static_cast<std::int32_t>((key >> shift) & 0x1FFFFF) - kVoxelOffset) * kEdge;
    };
    const Voxel corner{axis(42), axis(21), axis(0)};
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(brick.size()); ++k) {
      if (const float v = brick[static_cast<std::size_t>(k)]; v != kUnknown) {
        visit(Voxel{corner[0] + k / (kEdge * kEdge), corner[1] + k / kEdge % kEdge, corner[2] + k % kEdge}, v);
      }
    }
  }
}

}  // namespace hgg
