#include "map/class_evidence.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/classes.h"
#include "core/position_uncertainty.h"
#include "core/se3.h"
#include "core/units.h"
#include "map/sight.h"

namespace hgg {
namespace {

// Chosen by hand but for kCoincident; the tables of docs/experiments.md, "Class and existence", were measured with
// them.
constexpr std::size_t kMostLeaves = 24;                 // of a thing that vote, spread evenly over it: bounds the work
constexpr double kFullWay = 0.05, kFullTurn = kDegree;  // m, rad: motion after which a view counts in full
constexpr double kAtRest = 0.02;                        // weight of a view at rest
constexpr double kHalfVotePoints = 1;                   // points in a footprint that give its leaf half a vote
/// Standard deviations from its mean at which a footprint ends: it has fallen to exp(-4.5), one in a hundred.
constexpr double kFootprintSigmas = 3;
/// Share of a leaf's points in its own footprint: sqrt(|S| / |2 S|) in three dimensions.
const double kCoincident = std::sqrt(0.125);

/// Axis-aligned box around a Gaussian's mass.
struct Box {
  Eigen::Array3d low, high;
  Box(const Belief& b, double margin) {
    const Eigen::Array3d half = kFootprintSigmas * b.cov.diagonal().array().cwiseMax(0).sqrt() + margin;
    low = b.mean.array() - half, high = b.mean.array() + half;
  }
  bool contains(const Vec3& p) const { return (low <= p.array()).all() && (p.array() <= high).all(); }
  bool meets(const Box& other) const { return (low <= other.high).all() && (other.low <= high).all(); }
};

/// The soft footprint exp(-d^T Sigma^-1 d / 2) of a leaf, in the map frame; Sigma is the leaf's covariance with the
/// sensor's floor.
struct Footprint {
  Vec3 mean;
  Mat3 cov;
  double kappa, trace, determinant;
};

Footprint footprintOf(const Pose& T_map_object, const Belief& leaf, double sigma_floor) {
  const Belief b = transform(T_map_object, leaf);
  Footprint f{b.mean, b.cov, b.kappa, 0, 0};
  f.cov.diagonal().array() += sigma_floor * sigma_floor;
  f.trace = f.cov.trace();
  f.determinant = f.cov.determinant();
  return f;
}

/// Share of the points of `leaf` that is expected in the footprint: the integral of N(x; leaf) exp(-d^T Sigma^-1 d /
/// 2).
double shareIn(const Footprint& footprint, const Footprint& leaf) {
  const Vec3 d = leaf.mean - footprint.mean;
  if (d.squaredNorm() > kFootprintSigmas * kFootprintSigmas * (footprint.trace + leaf.trace)) {
    return 0;
  }
  const Mat3 sum = footprint.cov + leaf.cov;
  Mat3 inverse;
  double determinant = 0;
  bool invertible = false;
  sum.computeInverseAndDetWithCheck(inverse, determinant, invertible, 0.0);
  return invertible ? std::sqrt(footprint.determinant / determinant) * std::exp(-0.5 * d.dot(inverse * d)) : 0;
}

std::vector<Footprint> footprintsOf(const MapNode& node, double sigma_floor) {
  const Leaves& leaves = leavesOf(node);
  const std::size_t stride = (leaves.size() + kMostLeaves - 1) / kMostLeaves;
  std::vector<Footprint> footprints;
  for (std::size_t v = 0; v < leaves.size(); v += stride) {
    footprints.push_back(footprintOf(node.T_map_object, unpackLeaf(leaves[v]), sigma_floor));
  }
  return footprints;
}

std::vector<Footprint> footprintsOf(const LocalObject& object, const Pose& T_map_body, double sigma_floor) {
  const Pose T_map_object = T_map_body * object.T_body_object;
  std::vector<Footprint> footprints;
  footprints.reserve(object.leaves.size());
  for (const LocalLeaf& leaf : object.leaves) {
    footprints.push_back(footprintOf(T_map_object, leaf, sigma_floor));
  }
  return footprints;
}

/// An object of the frame, in the map frame. Its leaves are filled in when they are first needed.
struct Seen {
  const LocalObject* object;
  Box box;
  std::vector<Footprint> leaves;
};

/// Points of each class in the footprint.
ClassWeights pointsIn(const Footprint& footprint, const std::vector<const Seen*>& around) {
  ClassWeights points;
  for (const Seen* s : around) {
    double sum = 0;
    for (const Footprint& leaf : s->leaves) {
      sum += leaf.kappa * shareIn(footprint, leaf);
    }
    if (sum > 0) {
      addWeight(points, s->object->label, sum);
    }
  }
  return points;
}

/// How well the frame and the surface of the thing lie to each other, m; `drift` (m^2) is what the keyframe of the
/// frame and that of the thing may have drifted apart.
double sigmaOf(const MapNode& node, const FreeSpace& free, double drift) {
  const double way = (node.belief.mean - free.T_map_sensor.translation()).squaredNorm();
  const double views = std::max(node.views, 1);
  return std::sqrt(noiseVariance(kPositionWithinDrive, views) + free.variance + free.variance_turn * way + drift);
}

/// Every leaf of the thing votes for the class that has most points in its footprint, so that the few points of a
/// neighbour's that lie there do not count.
///
/// Free space gets what is left of the leaf's vote by the chance that a beam would have hit the leaf.
PlaceView viewAt(const MapNode& node, std::vector<Seen>& seen, const Pose& T_map_body, double sigma_floor,
                 const FreeSpace* free, double drift) {
  const Box box(node.belief, sigma_floor);
  std::vector<const Seen*> around;
  for (Seen& s : seen) {
    if (box.meets(s.box)) {
      if (s.leaves.empty()) {
        s.leaves = footprintsOf(*s.object, T_map_body, sigma_floor);
      }
      around.push_back(&s);
    }
  }
  PlaceView view;
  if (around.empty() && free == nullptr) {
    return view;
  }
  const std::vector<Footprint> footprints = footprintsOf(node, sigma_floor);
  const double share = 1 / static_cast<double>(std::max<std::size_t>(footprints.size(), 1));
  const double sigma = free != nullptr ? sigmaOf(node, *free, drift) : 0;
  const Pose T_sensor_map = free != nullptr ? free->T_map_sensor.inverse() : Pose::Identity();
  for (const Footprint& footprint : footprints) {
    const ClassWeights here = pointsIn(footprint, around);
    const auto most = std::ranges::max_element(here, {}, &ClassWeights::value_type::second);
    const double n = sumOf(here);
    if (most != here.end()) {
      addWeight(view.labels, most->first, n / (n + kHalfVotePoints) * share);
    }
    if (free != nullptr) {
      const Mat3 R = T_sensor_map.linear();
      BeamCount beams = free->image.beamsAt(T_sensor_map * footprint.mean, R * footprint.cov * R.transpose(), sigma);
      beams.ends = std::max(n, beams.ends);  // the image has some of the beams, the frame all
      view.taken += takenBy(beams) * share;
      view.through += seenThroughBy(beams) * share;
    }
  }
  return view;
}

/// Variance that the way between two keyframes adds, per axis.
struct Variance {
  double position = 0, turn = 0;  // m^2, rad^2
};

Variance varianceOf(const Map& map, KeyframeId id) {
  const Mat6 cov = map.poseCovariance(id);
  return {cov.topLeftCorner<3, 3>().trace() / 3, cov.bottomRightCorner<3, 3>().trace() / 3};
}

double shareOn(const MapNode& node, const std::vector<Footprint>& leaves, double sigma_floor) {
  std::vector<Footprint> footprints;
  for (const Leaf& leaf : leavesOf(node)) {
    footprints.push_back(footprintOf(node.T_map_object, unpackLeaf(leaf), sigma_floor));
  }
  double on = 0, all = 0;
  for (const Footprint& leaf : leaves) {
    double share = 0;
    for (const Footprint& footprint : footprints) {
      share += shareIn(footprint, leaf);
    }
    on += leaf.kappa * std::min(share / kCoincident, 1.0), all += leaf.kappa;
  }
  return all > 0 ? on / all : 0;
}

}  // namespace

std::vector<ClassEvidence> classEvidence(const LocalGraph& local, const Map& map, const Pose& T_map_body, double weight,
                                         double radius, double sigma_floor, const FreeSpace* free) {
  std::vector<Seen> seen;
  for (const LocalObject& object : local.objects) {
    if (object.label != kUnknownClass) {  // what nobody has named speaks for no class and against none
      seen.push_back({&object, Box(transform(T_map_body, object.belief), sigma_floor), {}});
    }
  }
  std::vector<ClassEvidence> evidence;
  const Variance here = free != nullptr ? varianceOf(map, map.keyframes().current()) : Variance{};
  for (const NodeId id : map.near(T_map_body.translation(), radius)) {
    const MapNode& node = *map.find(id);
    if (node.stuff) {
      continue;
    }
    double drift = 0;
    if (free != nullptr) {
      const Variance there = varianceOf(map, node.anchor);
      drift = std::abs(here.position - there.position) +
              std::abs(here.turn - there.turn) * (node.belief.mean - T_map_body.translation()).squaredNorm();
    }
    PlaceView view = viewAt(node, seen, T_map_body, sigma_floor, free, drift);
    for (auto& [label, amount] : view.labels) {
      amount *= static_cast<float>(weight);
    }
    view.through *= weight, view.taken *= weight;
    view.is_found = free != nullptr && std::ranges::binary_search(free->found, id) ? weight : 0;
    if (!view.labels.empty() || view.through > 0) {
      evidence.push_back({id, std::move(view)});
    }
  }
  return evidence;
}

double viewWeight(const Pose& T_last_body) {
  const double way = T_last_body.translation().norm(), turn = turnOf(T_last_body);
  return std::clamp(way / kFullWay + turn / kFullTurn, kAtRest, 1.0);
}

namespace {

/// How many times as many points the node has in the footprints as their leaves bring, on average; no more than it has
/// views.
double timesSeen(const MapNode& node, const std::vector<Footprint>& footprints, const Box& box, double sigma_floor) {
  std::vector<double> points(footprints.size(), 0);
  for (const Leaf& leaf : leavesOf(node)) {
    const Footprint piece = footprintOf(node.T_map_object, unpackLeaf(leaf), sigma_floor);
    if (box.contains(piece.mean)) {
      for (std::size_t k = 0; k < footprints.size(); ++k) {
        points[k] += piece.kappa * shareIn(footprints[k], piece);
      }
    }
  }
  double times = 0;
  for (std::size_t k = 0; k < footprints.size(); ++k) {
    times += std::min<double>(points[k] / (kCoincident * footprints[k].kappa), node.views);
  }
  return times / static_cast<double>(std::max<std::size_t>(footprints.size(), 1));
}

}  // namespace

ClassWeights viewsAsStuff(const Map& map, const LocalObject& object, const Pose& T_map_body, double sigma_floor) {
  const Belief thing = transform(T_map_body, object.belief);
  const Box box(thing, sigma_floor);
  const std::vector<Footprint> own = footprintsOf(object, T_map_body, sigma_floor);
  ClassWeights views;
  // A tile's mean may lie as far away as the tile's corner is from its middle.
  const double reach = std::sqrt(3.0) * map.tileSize() + kFootprintSigmas * std::sqrt(thing.cov.trace());
  for (const NodeId id : map.near(thing.mean, reach)) {
    const MapNode& node = *map.find(id);
    if (!node.stuff || node.label == kUnknownClass || !box.meets(Box(node.belief, sigma_floor))) {
      continue;
    }
    if (const double times = timesSeen(node, own, box, sigma_floor); times > 0) {
      addWeight(views, node.label, times);
    }
  }
  return views;
}

double shareOn(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double sigma_floor) {
  return shareOn(node, footprintsOf(object, T_map_body, sigma_floor), sigma_floor);
}

double shareOn(const MapNode& node, const MapNode& other, double sigma_floor) {
  return shareOn(node, footprintsOf(other, sigma_floor), sigma_floor);
}

}  // namespace hgg
