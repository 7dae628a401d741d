#include "correction/geometry_window.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "correction/em.h"

namespace hgg {
namespace {

constexpr std::size_t kViews = 5;  // keyframes
constexpr int kIterations = 2;
constexpr double kGate = 3;          // standard deviations
constexpr double kFewestPoints = 1;  // a leaf that EM leaves with less evidence is none

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

double evidenceOf(const std::vector<Belief>& leaves) {
  return std::accumulate(leaves.begin(), leaves.end(), 0.0, [](double sum, const Belief& b) { return sum + b.kappa; });
}

/// The points of a node in the window.
struct Sample {
  std::vector<Vec3> points;  // object frame
  double measured = 0;       // points that they stand for
};

/// EM lays evidence on other leaves and makes none: all of it was counted when the frames were fused. What no point of
/// the window has touched stays as it is, the others share the evidence that they had.
Leaves refined(const Leaves& leaves, const Sample& sample, EmOptions options) {
  std::vector<Belief> start;
  start.reserve(leaves.size());
  for (const Leaf& leaf : leaves) {
    start.push_back(unpackLeaf(leaf));
  }
  // Not every frame between two keyframes saw the node: its points stand for no more than it was given.
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
                         const Config& config) {
  const auto most = static_cast<std::size_t>(config.correction.em_points);
  const std::size_t stride = std::max<std::size_t>(1, (local.points.size() + most - 1) / most);
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
  std::map<NodeId, Sample> samples;
  for (const View& view : views_) {
    const Pose& T_map_body = map.keyframes().poses()[static_cast<std::size_t>(view.keyframe)].T_map_body;
    for (const Part& part : view.parts) {
      const MapNode* node = map.find(part.id);
      if (node == nullptr || (part.id + views_.back().keyframe) % static_cast<NodeId>(kViews) != 0) {
        continue;
      }
      const Pose T_object_body = node->T_map_object.inverse() * T_map_body;
      for (const Eigen::Vector3f& p : part.points_body) {
        Sample& sample = samples[part.id];
        sample.points.push_back(T_object_body * p.cast<double>());
        sample.measured += view.point_weight;
      }
    }
  }
  const double floor = config.creation.sigma_floor;
  const EmOptions options{floor * floor, kIterations, kGate, 1};
  std::vector<MapNode> nodes;
  for (const auto& [id, sample] : samples) {
    nodes.push_back(*map.find(id));
    nodes.back().geometry = shareLeaves(refined(leavesOf(nodes.back()), sample, options));
  }
  return nodes;
}

}  // namespace hgg
