#include "map/same_thing.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/spd.h"
#include "core/units.h"
#include "map/patch.h"

namespace hgg {
namespace {

/// Half of a box's side in standard deviations of what is spread over it: sqrt(3) where it is evenly filled, about two
/// where only one side was seen. Chosen by hand between these and more, not measured.
constexpr double kBoxSigmas = 2;

/// True when `p` lies inside the box of the belief's extent.
bool boxContains(const Belief& b, const Vec3& p, double sigma_floor) {
  const Eigen3 e = eigenSymmetric(withFloor(b.cov, sigma_floor));
  const Vec3 d = (e.vectors.transpose() * (p - b.mean)).cwiseAbs();
  return (d.array() < kBoxSigmas * e.values.array().sqrt()).all();
}

/// True when the surfaces of the nodes' leaves come closer than `radius`: what clustering calls one object within a
/// frame.
bool touch(const MapNode& a, const MapNode& b, double radius) {
  const Pose T_a_b = a.T_map_object.inverse() * b.T_map_object;
  return std::ranges::any_of(leavesOf(b), [&](const Leaf& leaf_b) {
    const Belief piece = transform(T_a_b, unpackLeaf(leaf_b));
    return std::ranges::any_of(leavesOf(a),
                               [&](const Leaf& leaf_a) { return surfaceGap(unpackLeaf(leaf_a), piece) < radius; });
  });
}

}  // namespace

SameThing sameThing(const ClassInfo* info, const Config& config) {
  return {info != nullptr ? info->cluster_radius : 0, config.creation.sigma_floor, config.map.merge_overlap,
          config.map.fragment_share};
}

bool areOneObject(const MapNode& a, const MapNode& b, const SameThing& rule) {
  const bool a_larger = a.belief.cov.trace() >= b.belief.cov.trace();
  const Belief &large = a_larger ? a.belief : b.belief, &small = a_larger ? b.belief : a.belief;
  const bool a_stronger = a.belief.kappa >= b.belief.kappa;
  const MapNode &whole = a_stronger ? a : b, &piece = a_stronger ? b : a;
  return boxContains(large, small.mean, rule.sigma_floor) ||
         bhattacharyyaCoefficient(large, small, rule.sigma_floor) > rule.merge_overlap ||
         (piece.belief.kappa < rule.fragment_share * whole.belief.kappa &&
          touch(whole, piece, kFragmentDistance * rule.cluster_radius));
}

bool canBeViewOf(const MapNode& node, const LocalObject& object, const Pose& T_map_body, double reach,
                 double sigma_floor) {
  const Belief here = transform(T_map_body, object.belief);
  if (boxContains(node.belief, here.mean, sigma_floor) || boxContains(here, node.belief.mean, sigma_floor)) {
    return true;
  }
  const Pose T_node_object = node.T_map_object.inverse() * T_map_body * object.T_body_object;
  return std::ranges::any_of(object.leaves, [&](const LocalLeaf& leaf) {
    const Belief piece = transform(T_node_object, leaf);
    return std::ranges::any_of(leavesOf(node),
                               [&](const Leaf& known) { return surfaceGap(unpackLeaf(known), piece) < reach; });
  });
}

void keepViews(std::vector<ObjectPair>& pairs, const Map& map, const LocalGraph& local, const Pose& T_map_body,
               const ClassTable& classes, const Config& config) {
  const double per_range = config.creation.beam_factor * config.creation.beam_spacing_deg * kDegree;
  std::erase_if(pairs, [&](const ObjectPair& pair) {
    const LocalObject& object = local.objects[static_cast<std::size_t>(pair.local)];
    const SameThing rule = sameThing(classes.find(object.label), config);
    const double reach = std::max(kFragmentDistance * rule.cluster_radius, per_range * object.belief.mean.norm());
    return !object.stuff && !canBeViewOf(*map.find(pair.map), object, T_map_body, reach, rule.sigma_floor);
  });
}

}  // namespace hgg
