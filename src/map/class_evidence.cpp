#include "map/class_evidence.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr std::size_t kMostLeaves = 24;                 // of a thing that are asked, spread evenly over it
constexpr double kFullWay = 0.05, kFullTurn = kDegree;  // m, rad: motion that makes a view a new one
constexpr double kAtRest = 0.02;                        // of a view
constexpr double kReach = 3;                            // standard deviations
const double kCoincident = std::sqrt(0.125);            // share of a leaf's points in the window of one just like it

/// Axis-aligned box around a Gaussian's mass.
struct Box {
  Eigen::Array3d low, high;
  Box(const Belief& b, double margin) {
    const Eigen::Array3d half = kReach * b.cov.diagonal().array().cwiseMax(0).sqrt() + margin;
    low = b.mean.array() - half, high = b.mean.array() + half;
  }
  bool meets(const Box& other) const { return (low <= other.high).all() && (other.low <= high).all(); }
};

/// A leaf in the map frame, its covariance with the sensor's floor.
struct Window {
  Vec3 mean;
  Mat3 cov;
  double kappa, trace, determinant;
};

Window windowOf(const Pose& T_map_object, const Belief& leaf, double sigma_floor) {
  const Belief b = transform(T_map_object, leaf);
  Window w{b.mean, b.cov, b.kappa, 0, 0};
  w.cov.diagonal().array() += sigma_floor * sigma_floor;
  w.trace = w.cov.trace();
  w.determinant = w.cov.determinant();
  return w;
}

/// Share of the points of `leaf` expected in the soft window: the integral of N(x; leaf) exp(-d^T Sigma^-1 d / 2).
double shareIn(const Window& window, const Window& leaf) {
  const Vec3 d = leaf.mean - window.mean;
  if (d.squaredNorm() > kReach * kReach * (window.trace + leaf.trace)) {
    return 0;
  }
  const Mat3 sum = window.cov + leaf.cov;
  Mat3 inverse;
  double determinant = 0;
  bool invertible = false;
  sum.computeInverseAndDetWithCheck(inverse, determinant, invertible, 0.0);
  return invertible ? std::sqrt(window.determinant / determinant) * std::exp(-0.5 * d.dot(inverse * d)) : 0;
}

std::vector<Window> windowsOf(const MapNode& node, double sigma_floor) {
  const Leaves& leaves = leavesOf(node);
  const std::size_t stride = (leaves.size() + kMostLeaves - 1) / kMostLeaves;
  std::vector<Window> windows;
  for (std::size_t v = 0; v < leaves.size(); v += stride) {
    windows.push_back(windowOf(node.T_map_object, unpackLeaf(leaves[v]), sigma_floor));
  }
  return windows;
}

std::vector<Window> windowsOf(const LocalObject& object, const Pose& T_map_body, double sigma_floor) {
  const Pose T_map_object = T_map_body * object.T_body_object;
  std::vector<Window> windows;
  windows.reserve(object.leaves.size());
  for (const LocalLeaf& leaf : object.leaves) {
    windows.push_back(windowOf(T_map_object, leaf, sigma_floor));
  }
  return windows;
}

/// An object of the frame in the map frame, its leaves once somebody asks.
struct Seen {
  const LocalObject* object;
  Box box;
  std::vector<Window> leaves;
};

/// Points of each class in the window.
ClassWeights pointsIn(const Window& window, const std::vector<const Seen*>& around) {
  ClassWeights points;
  for (const Seen* s : around) {
    double sum = 0;
    for (const Window& leaf : s->leaves) {
      sum += leaf.kappa * shareIn(window, leaf);
    }
    if (sum > 0) {
      addWeight(points, s->object->label, sum);
    }
  }
  return points;
}

/// Every leaf of the thing speaks for the class that has most points in its window, so that what reaches over from a
/// neighbour does not count; one with a single point says half of what it can.
ClassWeights viewsAt(const MapNode& node, std::vector<Seen>& seen, const Pose& T_map_body, double sigma_floor) {
  const Box box(node.belief, sigma_floor);
  std::vector<const Seen*> around;
  for (Seen& s : seen) {
    if (box.meets(s.box)) {
      if (s.leaves.empty()) s.leaves = windowsOf(*s.object, T_map_body, sigma_floor);
      around.push_back(&s);
    }
  }
  ClassWeights views;
  const std::vector<Window> windows = around.empty() ? std::vector<Window>{} : windowsOf(node, sigma_floor);
  for (const Window& window : windows) {
    const ClassWeights here = pointsIn(window, around);
    const auto most = std::ranges::max_element(here, {}, &ClassWeights::value_type::second);
    if (most != here.end()) {
      const double n = sumOf(here);
      addWeight(views, most->first, n / (n + 1) / static_cast<double>(windows.size()));
    }
  }
  return views;
}

}  // namespace

std::vector<ClassEvidence> classEvidence(const LocalGraph& local, const Map& map, const Pose& T_map_body, double weight,
                                         const Config& config) {
  const double floor = config.creation.sigma_floor;
  std::vector<Seen> seen;
  for (const LocalObject& object : local.objects) {
    seen.push_back({&object, Box(transform(T_map_body, object.belief), floor), {}});
  }
  std::vector<ClassEvidence> evidence;
  for (const NodeId id : map.near(T_map_body.translation(), config.map.active_radius)) {
    const MapNode& node = *map.find(id);
    ClassWeights views = node.stuff ? ClassWeights{} : viewsAt(node, seen, T_map_body, floor);
    for (auto& [label, amount] : views) {
      amount *= static_cast<float>(weight);
    }
    if (!views.empty()) {
      evidence.push_back({id, std::move(views)});
    }
  }
  return evidence;
}

double viewWeight(const Pose& T_last_body) {
  const double way = T_last_body.translation().norm(), turn = turnOf(T_last_body);
  return std::clamp(way / kFullWay + turn / kFullTurn, kAtRest, 1.0);
}

double shareOn(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double sigma_floor) {
  std::vector<Window> windows;
  for (const Leaf& leaf : leavesOf(node)) {
    windows.push_back(windowOf(node.T_map_object, unpackLeaf(leaf), sigma_floor));
  }
  double on = 0, all = 0;
  for (const Window& leaf : windowsOf(object, T_map_body, sigma_floor)) {
    double share = 0;
    for (const Window& window : windows) {
      share += shareIn(window, leaf);
    }
    on += leaf.kappa * std::min(share / kCoincident, 1.0), all += leaf.kappa;
  }
  return all > 0 ? on / all : 0;
}

}  // namespace hgg
