#include "eval/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>
#include <unordered_set>

#include "core/spd.h"

namespace hgg {
namespace {

constexpr double kCropRadius = 3.0;  // m
constexpr double kPairRadius = 1.0;  // m, of the alignment
constexpr std::size_t kAlignPoints = 20'000;
constexpr int kAlignRounds = 50;
constexpr double kAligned = 1e-5;  // m and rad: smaller steps end the alignment
constexpr double kMaxLeafSamples = 1e5;

/// nanoflann's view of a point set.
struct PointsAdaptor {
  const PointSet& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class NearestPoint {
 public:
  explicit NearestPoint(const PointSet& points) : adaptor_{points}, tree_(3, adaptor_, {16}) {}
  struct Found {
    std::size_t index = 0;
    float square = 0;
  };
  Found operator()(const Eigen::Vector3f& p) const {
    Found found;
    tree_.knnSearch(p.data(), 1, &found.index, &found.square);
    return found;
  }

 private:
  PointsAdaptor adaptor_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointsAdaptor>, PointsAdaptor, 3, std::size_t>
      tree_;
};

using Voxel = std::array<std::int32_t, 3>;
struct VoxelHash {
  std::size_t operator()(const Voxel& v) const {
    std::uint64_t h = 0;
    for (const std::int32_t k : v) {
      h = (h ^ static_cast<std::uint32_t>(k)) * 0x9e3779b97f4a7c15ULL;
      h ^= h >> 29;
    }
    return h;
  }
};
using VoxelSet = std::unordered_set<Voxel, VoxelHash>;

Voxel voxelOf(const Eigen::Vector3f& p, double size) {
  const auto index = [&](Eigen::Index k) {
    return static_cast<std::int32_t>(std::floor(static_cast<double>(p[k]) / size));
  };
  return {index(0), index(1), index(2)};
}

/// Point i of the sequence that fills the unit cube evenly (additive recurrence by powers of the plastic number's kin).
Vec3 evenPoint(std::size_t i) {
  constexpr double kRoot = 1.2207440846057594754;  // of x^4 = x + 1
  const Vec3 step(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
  const Vec3 at = Vec3::Constant(0.5) + static_cast<double>(i) * step;
  return at - at.array().floor().matrix();
}

void sampleLeaf(const Belief& leaf, double spacing, PointSet& points) {
  const Eigen3 e = eigenSymmetric(leaf.cov);
  const Vec3 half = (3 * e.values.cwiseMax(0.0)).cwiseSqrt();
  const Vec3 wanted = (2 * half / spacing).array().ceil().max(1.0);
  const auto n = static_cast<std::size_t>(std::min(wanted[1] * wanted[2], kMaxLeafSamples));
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 in_box = (2 * evenPoint(i) - Vec3::Ones()).cwiseProduct(half);
    points.emplace_back((leaf.mean + e.vectors * in_box).cast<float>());
  }
}

double meanOf(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

PointSet everyNth(const PointSet& points, std::size_t at_most) {
  const std::size_t step = (points.size() + at_most - 1) / at_most;
  PointSet some;
  for (std::size_t i = 0; i < points.size(); i += step) {
    some.push_back(points[i]);
  }
  return some;
}

PointSet moved(const Pose& T, const PointSet& points) {
  PointSet out;
  out.reserve(points.size());
  for (const Eigen::Vector3f& p : points) {
    out.emplace_back((T * p.cast<double>()).cast<float>());
  }
  return out;
}

/// One round of ICP: the rigid transform that fits points to their nearest in the reference, as far as those are near.
Pose fitOnce(const PointSet& points, const PointSet& reference, const NearestPoint& nearest) {
  Eigen::Matrix3Xd from(3, points.size()), to(3, points.size());
  Eigen::Index n = 0;
  for (const Eigen::Vector3f& p : points) {
    const NearestPoint::Found found = nearest(p);
    if (found.square <= static_cast<float>(kPairRadius * kPairRadius)) {
      from.col(n) = p.cast<double>();
      to.col(n++) = reference[found.index].cast<double>();
    }
  }
  return n < 3 ? Pose::Identity() : Pose(Eigen::umeyama(from.leftCols(n), to.leftCols(n), false));
}

}  // namespace

PointSet sampleLeaves(std::span<const Belief> leaves, double spacing) {
  PointSet points;
  for (const Belief& leaf : leaves) {
    sampleLeaf(leaf, spacing, points);
  }
  return points;
}

PointSet thin(const PointSet& points, double voxel) {
  VoxelSet taken;
  PointSet out;
  std::ranges::copy_if(points, std::back_inserter(out),
                       [&](const auto& p) { return taken.insert(voxelOf(p, voxel)).second; });
  return out;
}

PointSet cropTo(const PointSet& reference, const PointSet& estimate, double radius) {
  PointSet cropped;
  if (estimate.empty()) {
    return cropped;
  }
  // Two points of one cell are within the radius of each other: that decides nearly all without a search.
  const double cell = 0.999 * radius / std::sqrt(3.0);
  VoxelSet occupied;
  for (const Eigen::Vector3f& p : estimate) {
    occupied.insert(voxelOf(p, cell));
  }
  const NearestPoint nearest(estimate);
  std::ranges::copy_if(reference, std::back_inserter(cropped), [&](const Eigen::Vector3f& p) {
    return occupied.contains(voxelOf(p, cell)) || nearest(p).square <= static_cast<float>(radius * radius);
  });
  return cropped;
}

std::vector<double> nearestDistances(const PointSet& points, const PointSet& target) {
  const NearestPoint nearest(target);
  std::vector<double> distances(points.size());
  std::ranges::transform(points, distances.begin(),
                         [&](const Eigen::Vector3f& p) { return std::sqrt(nearest(p).square); });
  return distances;
}

Pose alignClouds(const PointSet& estimate, const PointSet& reference) {
  const PointSet points = everyNth(estimate, kAlignPoints);
  const NearestPoint nearest(reference);
  Pose T_reference_estimate = Pose::Identity();
  for (int round = 0; round < kAlignRounds; ++round) {
    const Pose step = fitOnce(moved(T_reference_estimate, points), reference, nearest);
    T_reference_estimate = step * T_reference_estimate;
    if (step.translation().norm() < kAligned && Eigen::AngleAxisd(step.linear()).angle() < kAligned) {
      break;
    }
  }
  return T_reference_estimate;
}

GeometryScore measureGeometry(const PointSet& estimate, const PointSet& reference, double spacing) {
  const PointSet from_estimate = thin(estimate, spacing), from_reference = thin(reference, spacing);
  GeometryScore score;
  score.estimate_points = from_estimate.size();
  score.reference_points = from_reference.size();
  const bool is_empty = estimate.empty() || reference.empty();
  score.accuracy = meanOf(is_empty ? std::vector<double>() : nearestDistances(from_estimate, reference));
  score.completeness = meanOf(is_empty ? std::vector<double>() : nearestDistances(from_reference, estimate));
  score.chamfer = 0.5 * (score.accuracy + score.completeness);
  return score;
}

double coverageOf(const PointSet& estimate, const PointSet& reference) {
  const auto near = static_cast<double>(cropTo(reference, estimate, kCropRadius).size());
  return reference.empty() ? std::numeric_limits<double>::quiet_NaN() : near / static_cast<double>(reference.size());
}

GeometryScore compareGeometry(const PointSet& estimate, const PointSet& reference, double spacing) {
  const PointSet cropped = cropTo(reference, estimate, kCropRadius);
  const Pose T = cropped.empty() ? Pose::Identity() : alignClouds(estimate, cropped);
  GeometryScore score = measureGeometry(moved(T, estimate), cropped, spacing);
  score.T_reference_estimate = T;
  return score;
}

}  // namespace hgg
