#include "sim/bvh.h"

#include <algorithm>
#include <numeric>

namespace hgg {
namespace {

constexpr int kBins = 16;
constexpr std::uint32_t kLeafItems = 2;
constexpr double kGrowth = 1e-6;  // m, and share of the coordinate

Bounds grown(const Bounds& b) {
  return {b.lo.array() - kGrowth * (1.0 + b.lo.array().abs()), b.hi.array() + kGrowth * (1.0 + b.hi.array().abs())};
}

Vec3 center(const Bounds& b) { return 0.5 * (b.lo + b.hi); }

double halfArea(const Bounds& b) {
  const Vec3 d = (b.hi - b.lo).cwiseMax(0.0);
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

struct Bin {
  Bounds bounds;
  std::uint32_t count = 0;

  double cost() const { return count == 0 ? 0.0 : count * halfArea(bounds); }
  void add(const Bin& other) {
    bounds = join(bounds, other.bounds);
    count += other.count;
  }
};

/// Puts centres into bins along an axis.
struct Binning {
  int axis;
  double lo, scale;

  Binning(const Bounds& centers, int along)
      : axis(along), lo(centers.lo[along]), scale(kBins * (1.0 - 1e-9) / (centers.hi[along] - centers.lo[along])) {}
  std::size_t bin(const Bounds& item) const { return static_cast<std::size_t>((center(item)[axis] - lo) * scale); }
};

struct Split {
  double cost = std::numeric_limits<double>::infinity();
  std::size_t bin = 0;  // the first bin of the second part
};

/// The cheapest place to cut a row of bins (surface area heuristic).
Split cheapestSplit(const std::array<Bin, kBins>& bins) {
  std::array<double, kBins> second_cost{};
  Bin second;
  for (std::size_t i = kBins - 1; i > 0; --i) {
    second.add(bins[i]);
    second_cost[i] = second.cost();
  }
  Split best;
  Bin first;
  for (std::size_t i = 1; i < kBins; ++i) {
    first.add(bins[i - 1]);
    const double cost = first.cost() + second_cost[i];
    if (cost < best.cost) {
      best = {cost, i};
    }
  }
  return best;
}

}  // namespace

Bounds join(const Bounds& a, const Bounds& b) { return {a.lo.cwiseMin(b.lo), a.hi.cwiseMax(b.hi)}; }

RaySlabs::RaySlabs(const Vec3& ray_origin, const Vec3& direction) : origin(ray_origin) {
  for (int axis = 0; axis < 3; ++axis) {
    const double inv = direction[axis] == 0.0 ? 1e300 : 1.0 / direction[axis];
    inverse[axis] = std::clamp(inv, -1e300, 1e300);
  }
}

Bvh::Bvh(const std::vector<Bounds>& items) : items_(items.size()) {
  std::iota(items_.begin(), items_.end(), 0U);
  if (!items.empty()) {
    nodes_.reserve(2 * items.size());
    build(items, 0, static_cast<std::uint32_t>(items.size()), 0);
  }
}

void Bvh::build(const std::vector<Bounds>& items, std::uint32_t first, std::uint32_t count, int depth) {
  const std::size_t self = nodes_.size();
  const std::span<std::uint32_t> mine(items_.data() + first, count);
  Bounds bounds, centers;
  for (const std::uint32_t item : mine) {
    bounds = join(bounds, items[item]);
    centers = join(centers, {center(items[item]), center(items[item])});
  }
  nodes_.push_back({grown(bounds), first, count});
  int axis = 0;
  const double longest = (centers.hi - centers.lo).maxCoeff(&axis);
  if (count <= kLeafItems || longest <= 0.0 || depth >= kMaxDepth) {
    return;
  }
  const Binning binning(centers, axis);
  std::array<Bin, kBins> bins;
  for (const std::uint32_t item : mine) {
    bins[binning.bin(items[item])].add({items[item], 1});
  }
  const Split split = cheapestSplit(bins);
  const auto middle = std::stable_partition(mine.begin(), mine.end(),
                                            [&](std::uint32_t item) { return binning.bin(items[item]) < split.bin; });
  const auto near_count = static_cast<std::uint32_t>(middle - mine.begin());
  nodes_[self].count = 0;
  build(items, first, near_count, depth + 1);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(items, first + near_count, count - near_count, depth + 1);
}

}  // namespace hgg
