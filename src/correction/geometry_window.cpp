#include "correction/geometry_window.h"

#include <algorithm>

#include "correction/em.h"

namespace hgg {
namespace {

constexpr std::size_t kViews = 5;  // keyframes
constexpr int kIterations = 2;
constexpr double kGate = 3;          // standard deviations
constexpr double kFewestPoints = 1;  // a leaf with less evidence is none

/// Each leaf without what the window's points gave it, as far as the leaves tell: evidence less the mass that the
/// points lay on it, the rest taken to be like the whole.
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

std::vector<Leaf> refined(const std::vector<Leaf>& leaves, const std::vector<Vec3>& points, const EmOptions& options) {
  std::vector<Belief> start;
  start.reserve(leaves.size());
  for (const Leaf& leaf : leaves) {
    start.push_back(unpackLeaf(leaf));
  }
  const EmResult result = refineLeaves(withoutWindow(start, points, options), start, points, options);
  std::vector<Leaf> out;
  out.reserve(leaves.size());
  for (const Belief& leaf : result.leaves) {
    if (leaf.kappa >= kFewestPoints) {
      out.push_back(packLeaf(leaf));
    }
  }
  return out;
}

}  // namespace

void GeometryWindow::add(KeyframeId keyframe, const LocalGraph& local, const std::vector<ObjectPair>& pairs, int frames,
                         const Config& config) {
  const auto most = static_cast<std::size_t>(config.correction.em_points);
  const std::size_t stride = 1 + local.points.size() / most;
  View view{keyframe, static_cast<double>(stride) * std::max(frames, 1), {}};
  for (const ObjectPair& pair : pairs) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    Part part{pair.map, {}};
    for (std::size_t k = (object.begin + stride - 1) / stride * stride; k < object.end; k += stride) {
      part.points_body.emplace_back(local.points[k].head<3>());
    }
    view.parts.push_back(std::move(part));
  }
  std::stable_sort(view.parts.begin(), view.parts.end(), [](const Part& a, const Part& b) { return a.id < b.id; });
  views_.push_back(std::move(view));
  if (views_.size() > kViews) {
    views_.pop_front();
  }
}

std::vector<MapNode> GeometryWindow::refine(const Map& map, const Config& config) const {
  std::map<NodeId, std::vector<Vec3>> points_of;  // object frame
  double weight = 0;
  for (const View& view : views_) {
    const Pose& T_map_body = map.keyframes().poses()[static_cast<std::size_t>(view.keyframe)].T_map_body;
    weight += view.point_weight / static_cast<double>(views_.size());
    for (const Part& part : view.parts) {
      const MapNode* node = map.find(part.id);
      if (node == nullptr || (part.id + views_.back().keyframe) % static_cast<NodeId>(kViews) != 0) {
        continue;
      }
      const Pose T_object_body = node->T_map_object.inverse() * T_map_body;
      for (const Eigen::Vector3f& p : part.points_body) {
        points_of[part.id].push_back(T_object_body * p.cast<double>());
      }
    }
  }
  const double floor = config.creation.sigma_floor;
  const EmOptions options{floor * floor, kIterations, kGate, weight};
  std::vector<MapNode> nodes;
  for (const auto& [id, points] : points_of) {
    nodes.push_back(*map.find(id));
    nodes.back().leaves = refined(nodes.back().leaves, points, options);
  }
  return nodes;
}

}  // namespace hgg
