#include "correction/geometry_window.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "correction/em.h"

namespace hgg {
namespace {

constexpr std::size_t kWindowSize = 5;  // keyframes
constexpr int kIterations = 2;
constexpr double kGate = 3;          // standard deviations, of EM
constexpr double kFewestPoints = 1;  // a leaf that EM leaves with less evidence is dropped

/// The leaves as they were before the window, which is not recorded: each one's evidence is reduced by the mass that
/// the window's points lay on it, and its mean and covariance are kept.
std::vector<Belief> withoutWindow(const std::vector<Belief>& leaves, const std::vector<Vec3>& points,
                                  const EmOptions& options) {
  const Sight sight = findSight(leaves, points, options);
  const Responsibilities responsibilities = eStep(leaves, points, sight, options.lambda);
  std::vector<Belief> prior = leaves;
  for (std::size_t k = 0; k < sight.leaf.size(); ++k) {
    Belief& leaf = prior[sight.leaf[k]];
    leaf.kappa = std::max(0.0, leaf.kappa - options.point_weight * responsibilities.gamma[k]);
  }
  return prior;
}

double evidenceOf(const std::vector<Belief>& leaves) {
  return std::accumulate(leaves.begin(), leaves.end(), 0.0, [](double sum, const Belief& b) { return sum + b.kappa; });
}

/// The points of a node in the window.
struct Sample {
  std::vector<Vec3> points;  // object frame
  double measured = 0;       // measured points that they stand for
};

/// EM moves evidence between leaves and adds none, because all of it was counted when the frames were fused. Leaves
/// that no point of the window reaches stay as they are; the others share the evidence that they had together.
Leaves refined(const Leaves& leaves, const Sample& sample, EmOptions options) {
  std::vector<Belief> start;
  start.reserve(leaves.size());
  for (const Leaf& leaf : leaves) {
    start.push_back(unpackLeaf(leaf));
  }
  // Not every frame between two keyframes saw the node, so its points stand for no more than the evidence it has.
  options.point_weight = std::min(sample.measured, evidenceOf(start)) / static_cast<double>(sample.points.size());
  std::vector<Belief> found =
      refineLeaves(withoutWindow(start, sample.points, options), start, sample.points, options).leaves;
  const auto isTouched = [&](std::size_t k) {
    return found[k].kappa != start[k].kappa || found[k].mean != start[k].mean;
  };
  const auto isLeft = [&](std::size_t k) { return found[k].kappa >= kFewestPoints; };
  double had = 0, has = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    had += isTouched(k) ? start[k].kappa : 0;
    has += isTouched(k) && isLeft(k) ? found[k].kappa : 0;
  }
  if (has <= 0) {
    return leaves;
  }
  Leaves out;
  out.reserve(found.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!isTouched(k)) {
      out.push_back(leaves[k]);
    } else if (isLeft(k)) {
      found[k].kappa *= had / has;
      out.push_back(packLeaf(found[k]));
    }
  }
  return out;
}

}  // namespace

void GeometryWindow::add(KeyframeId keyframe, const LocalGraph& local, const std::vector<ObjectPair>& pairs, int frames,
                         int max_points) {
  const auto most = static_cast<std::size_t>(max_points);
  const std::size_t stride = std::max<std::size_t>(1, (local.points.size() + most - 1) / most);
  Keyframe added{keyframe, static_cast<double>(stride) * std::max(frames, 1), {}};
  for (const ObjectPair& pair : pairs) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    NodePoints node{pair.map, {}};
    for (std::size_t k = (object.begin + stride - 1) / stride * stride; k < object.end; k += stride) {
      node.points_body.emplace_back(local.points[k].head<3>());
    }
    added.nodes.push_back(std::move(node));
  }
  std::ranges::stable_sort(added.nodes, {}, &NodePoints::id);
  keyframes_.push_back(std::move(added));
  if (keyframes_.size() > kWindowSize) {
    keyframes_.pop_front();
  }
}

std::vector<MapNode> GeometryWindow::refine(const Map& map, double sigma_floor) const {
  std::map<NodeId, Sample> samples;
  for (const Keyframe& keyframe : keyframes_) {
    const Pose& T_map_body = map.keyframes().poses()[static_cast<std::size_t>(keyframe.id)].T_map_body;
    for (const NodePoints& seen : keyframe.nodes) {
      const MapNode* node = map.find(seen.id);
      if (node == nullptr || (seen.id + keyframes_.back().id) % static_cast<NodeId>(kWindowSize) != 0) {
        continue;
      }
      const Pose T_object_body = node->T_map_object.inverse() * T_map_body;
      for (const Eigen::Vector3f& p : seen.points_body) {
        Sample& sample = samples[seen.id];
        sample.points.push_back(T_object_body * p.cast<double>());
        sample.measured += keyframe.point_weight;
      }
    }
  }
  const EmOptions options{sigma_floor * sigma_floor, kIterations, kGate, 1};
  std::vector<MapNode> nodes;
  for (const auto& [id, sample] : samples) {
    nodes.push_back(*map.find(id));
    nodes.back().geometry = shareLeaves(refined(leavesOf(nodes.back()), sample, options));
  }
  return nodes;
}

}  // namespace hgg
