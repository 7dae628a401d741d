#pragma once

#include <span>
#include <vector>

#include "core/belief.h"

namespace hgg {

/// Positions in m, map frame.
using PointSet = std::vector<Eigen::Vector3f>;

/// Points that stand for the leaves: each leaf is the box that is filled evenly with the leaf's own moments (half
/// widths sqrt(3) standard deviations, on all three axes, so a blurred leaf is a thick one), sampled by a fixed
/// low-discrepancy sequence: a point for every `spacing` x `spacing` of its two long axes, at least one.
PointSet sampleLeaves(std::span<const Belief> leaves, double spacing);

/// The first point of every voxel, in order: what is measured over these does not weigh dense places more.
PointSet thin(const PointSet& points, double voxel);

/// The points of `reference` within `radius` of a point of `estimate`, in order.
PointSet cropTo(const PointSet& reference, const PointSet& estimate, double radius);

/// Distance from each point to the nearest of `target`, which must not be empty.
std::vector<double> nearestDistances(const PointSet& points, const PointSet& target);

struct GeometryScore {
  double accuracy = 0;      // m, mean distance from the estimate to the reference ("map accuracy")
  double completeness = 0;  // m, mean distance from the cropped reference to the estimate
  double chamfer = 0;       // m, mean of the two
  std::size_t estimate_points = 0, reference_points = 0;  // compared: thinned, and cropped
  Pose T_reference_estimate = Pose::Identity();           // what the alignment moved
  double left_out = 0;  // share of the map's leaves too far from the path to be told right from wrong
  double coverage = 0;  // share of the reference along the path that the map came near, see coverageOf()
};

/// Protocol of the paper's correction ablation (PALoc / MapEval): the reference is cropped to 3 m around the estimate,
/// so that what was never passed does not count, then the estimate is aligned to it (point-to-point ICP, pairs within 1
/// m), then distances to the nearest point are averaged both ways. Points are thinned to one a voxel of `spacing` on
/// the asking side only. NaN where either side is empty.
GeometryScore compareGeometry(const PointSet& estimate, const PointSet& reference, double spacing);

/// Share of `reference` that survives the crop of compareGeometry(). What a map leaves out costs it neither accuracy
/// nor completeness where that is far from everything it has: it shows here. NaN without a reference.
double coverageOf(const PointSet& estimate, const PointSet& reference);

/// The comparison alone: no crop, no alignment.
GeometryScore measureGeometry(const PointSet& estimate, const PointSet& reference, double spacing);

/// Rigid transform that lays `estimate` over `reference` by point-to-point ICP from where they are.
Pose alignClouds(const PointSet& estimate, const PointSet& reference);

}  // namespace hgg
