#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/random.h"
#include "sim/raycaster.h"

namespace hgg {

/// Where the body is; defined for every time from 0 on.
using Trajectory = std::function<Pose(double time)>;

/// The rays of a sensor as an image: a LiDAR's beams over its columns, or a camera's pixels.
struct RayGrid {
  int width = 0, height = 0;
  bool wraps = false;                       // the last column is beside the first
  double pitch_x_deg = 0, pitch_y_deg = 0;  // angle between neighbours
  Pose T_body_sensor = Pose::Identity();
  std::vector<Vec3> directions;  // unit vectors in the sensor frame, row by row

  std::size_t size() const { return directions.size(); }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// How ranges go wrong.
struct RangeErrors {
  double range_min = 0, range_max = 0;  // m
  double noise = 0;                     // standard deviation, m
  double noise_per_m2 = 0;              // grows with the square of the range: depth from disparity
  double dropout = 0;                   // share of returns lost
  double grazing_deg = 0;               // rays flatter than this on the surface get lost: none at it, all at 0
  double foliage_depth = 0;             // m a ray gets into foliage on average before it is returned; 0: it is solid
  double mixed = 0;                     // share of returns at an edge that lie between its two surfaces
};

/// A return is at an edge when a neighbour's range differs by more than this.
constexpr double kEdgeStep = 0.3;

/// What a grid of rays met.
struct Scan {
  std::vector<float> range;            // m, measured; 0 = no return
  std::vector<std::int32_t> object;    // index into World::objects, returned or not; -1 = nothing there
  std::vector<std::uint8_t> mixed;     // 1: the return lies between two surfaces, on no object
  std::vector<float> true_range = {};  // m, to what returned; 0 = no return
};

/// When a scan was taken: all rays at `time`, or, where `sweep` > 0, column after column over the `sweep` seconds up to
/// `time`, the last column at `time`.
struct Exposure {
  double time = 0, sweep = 0;
};
double columnTime(const RayGrid& grid, const Exposure& exposure, int column);

/// Casts the rays of the grid. Every value depends on the key and its ray alone: not on the number of threads.
Scan measure(RayCaster& caster, const World& world, const RayGrid& grid, const RangeErrors& errors,
             const Trajectory& T_world_body, const Exposure& exposure, const RandomKey& key, int threads);

/// Runs `work(i)` for i in 0..count-1 on `threads` threads, in any order.
void parallelFor(int count, int threads, const std::function<void(int)>& work);

/// What randomness is for: no two purposes, sensors or frames share numbers.
enum class Purpose : std::uint64_t {
  kOdometry = 1,
  kRanges,
  kObjectLabels,
  kPixelLabels,
  kOdometryFaults,
  kKidnap,
  kCommonConfusion
};
inline RandomKey keyFor(std::uint64_t seed, Purpose purpose, std::uint64_t sensor, std::uint64_t frame) {
  return {seed, static_cast<std::uint64_t>(purpose) << 56 | sensor << 48 | frame};
}

}  // namespace hgg
