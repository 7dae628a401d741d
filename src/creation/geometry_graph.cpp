#include "creation/geometry_graph.h"

#include <algorithm>
#include <cmath>

#include "core/spd.h"

namespace hgg {
namespace {

/// A part with a smaller share of the points is a sliver. Chosen by hand: it only bounds the depth of the partition.
constexpr std::size_t kSliver = 16;  // one in 16

struct Split {
  int axis = 0;
  float at = 0;
  float width = 0;
};

Split widestAxis(std::span<const PackedPoint> points) {
  PackedPoint low = points[0], high = points[0], sum = PackedPoint::Zero();
  for (const PackedPoint& p : points) {
    low = low.min(p), high = high.max(p);
    sum += p - points[0];
  }
  Split split;
  split.width = (high - low).head<3>().maxCoeff(&split.axis);
  split.at = points[0][split.axis] + sum[split.axis] / static_cast<float>(points.size());
  return split;
}

/// Number of points that go left, 0 where all coincide. Falls back to the median where the mean would cut off a sliver,
/// so depth stays logarithmic.
std::size_t splitPoints(std::span<PackedPoint> points, const Split& split) {
  if (split.width == 0) {
    return 0;
  }
  const auto middle =
      std::partition(points.begin(), points.end(), [&](const PackedPoint& p) { return p[split.axis] < split.at; });
  const auto left = static_cast<std::size_t>(middle - points.begin());
  if (kSliver * std::min(left, points.size() - left) >= points.size()) {
    return left;
  }
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2), points.end(),
                   [&](const PackedPoint& p, const PackedPoint& q) { return p[split.axis] < q[split.axis]; });
  return points.size() / 2;
}

LocalLeaf leafOf(std::span<const PackedPoint> points, const Pose& T_body_object) {
  Moments moments(points[0].head<3>().cast<double>());
  for (const PackedPoint& p : points) {
    moments.add(p[0], p[1], p[2]);
  }
  const Belief b = moments.belief();
  const Mat3 R = T_body_object.linear();
  return {R.transpose() * (b.mean - T_body_object.translation()), R.transpose() * b.cov * R, b.kappa};
}

/// Where few points leave a wide part, a gap may lie in it that no surface spans. Sorts the points along their widest
/// axis and returns how many lie before the widest gap, 0 when no gap is wider than `bridge` at that range.
std::size_t splitAtGap(std::span<PackedPoint> points, const RadiusLaw& bridge) {
  const Split split = widestAxis(points);
  const float allowed = bridge.at(std::sqrt((points[0] * points[0]).sum()));
  if (split.width <= allowed) {
    return 0;
  }
  std::sort(points.begin(), points.end(),
            [&](const PackedPoint& p, const PackedPoint& q) { return p[split.axis] < q[split.axis]; });
  std::size_t before = 0;
  float widest = allowed;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const float gap = points[k][split.axis] - points[k - 1][split.axis];
    if (gap > widest) {
      widest = gap;
      before = k;
    }
  }
  return before;
}

struct Partition {
  std::size_t leaf_points = 0;
  RadiusLaw bridge;
  Pose T_body_object;
  std::vector<LocalLeaf> leaves;

  void add(std::span<PackedPoint> points) {
    const std::size_t left =
        points.size() > leaf_points ? splitPoints(points, widestAxis(points)) : splitAtGap(points, bridge);
    if (left == 0) {
      leaves.push_back(leafOf(points, T_body_object));
      return;
    }
    add(points.first(left));
    add(points.subspan(left));
  }
};

}  // namespace

std::vector<LocalLeaf> partitionLeaves(std::span<PackedPoint> points, const Pose& T_body_object, int leaf_points,
                                       const RadiusLaw& bridge) {
  Partition partition{static_cast<std::size_t>(std::max(leaf_points, 1)), bridge, T_body_object, {}};
  if (!points.empty()) {
    partition.add(points);
  }
  return std::move(partition.leaves);
}

}  // namespace hgg
