#include "map/same_thing.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/spd.h"
#include "core/units.h"
#include "map/class_evidence.h"
#include "map/patch.h"

namespace hgg {
namespace {

/// Half of a box's side in standard deviations of what is spread over it: sqrt(3) where it is evenly filled, about two
/// where only one side was seen. Chosen by hand between these and more, not measured.
constexpr double kBoxSigmas = 2;

/// An object with a larger share of its points on the surface of a thing is that thing. Chosen by hand, not measured.
constexpr double kSameSurface = 0.5;

/// The place of a thing under another name is also called what the thing is, so many times as often as that name. Where
/// names are right it is not: signs on poles had 0 to 0.2, other names for cars and people 0.35 to 0.9 (one street).
constexpr double kAlsoCalled = 0.25;

/// A thing with a larger share of its points within reach of another of its class is a piece of that. Measured pieces
/// of one thing have 0.5 to 1, neighbours up to 0.1 (docs/experiments.md, "Pieces, neighbours and other names").
constexpr double kAttached = 0.5;

/// True when `p` lies inside the box of the belief's extent.
bool boxContains(const Belief& b, const Vec3& p, double sigma_floor) {
  const Eigen3 e = eigenSymmetric(withFloor(b.cov, sigma_floor));
  const Vec3 d = (e.vectors.transpose() * (p - b.mean)).cwiseAbs();
  return (d.array() < kBoxSigmas * e.values.array().sqrt()).all();
}

/// False when a place is so far from the belief that no thing around it can lie on that one's surface.
bool reaches(const Belief& b, const Vec3& p) {
  return (p - b.mean).squaredNorm() < square(kBoxSigmas + 1) * std::max(b.cov.trace(), 0.0);
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

/// True when most points of the smaller node are in leaves that clustering would join with a leaf of the larger one.
/// Cars that are parked side by side touch nowhere, and where leaves blur the gap between them, the few that face it.
bool isAttached(const MapNode& large, const MapNode& small, double radius) {
  const double way = kPatchSigmas * (std::sqrt(std::max(large.belief.cov.trace(), 0.0)) +
                                     std::sqrt(std::max(small.belief.cov.trace(), 0.0)));
  if ((large.belief.mean - small.belief.mean).norm() > 2 * way + radius) {
    return false;
  }
  std::vector<Belief> known;
  for (const Leaf& leaf : leavesOf(large)) {
    known.push_back(unpackLeaf(leaf));
  }
  const Pose T_large_small = large.T_map_object.inverse() * small.T_map_object;
  double on = 0, all = 0;
  for (const Leaf& leaf : leavesOf(small)) {
    const Belief piece = transform(T_large_small, unpackLeaf(leaf));
    const bool is_on = std::ranges::any_of(known, [&](const Belief& k) { return surfaceGap(k, piece) < radius; });
    on += is_on ? piece.kappa : 0, all += piece.kappa;
  }
  return on > kAttached * all;
}

}  // namespace

SameThing sameThing(const ClassInfo* info, const Config& config) {
  return {info != nullptr ? info->cluster_radius : 0,
          info == nullptr || !info->dynamic,
          config.creation.sigma_floor,
          config.map.merge_overlap,
          config.map.fragment_share,
          config.alignment.gate,
          config.ablation.loose_pieces};
}

bool areOneObject(const MapNode& a, const MapNode& b, const SameThing& rule) {
  const bool a_larger = a.belief.cov.trace() >= b.belief.cov.trace();
  const Belief &large = a_larger ? a.belief : b.belief, &small = a_larger ? b.belief : a.belief;
  const bool a_stronger = a.belief.kappa >= b.belief.kappa;
  const MapNode &whole = a_stronger ? a : b, &piece = a_stronger ? b : a;
  const bool is_near = (a.belief.mean - b.belief.mean).norm() < rule.gate;
  return (is_near && boxContains(large, small.mean, rule.sigma_floor)) ||
         bhattacharyyaCoefficient(large, small, rule.sigma_floor) > rule.merge_overlap ||
         (is_near && piece.belief.kappa < rule.fragment_share * whole.belief.kappa &&
          touch(whole, piece, kFragmentDistance * rule.cluster_radius)) ||
         (!rule.loose_pieces && rule.has_parts && isAttached(a_larger ? a : b, a_larger ? b : a, rule.cluster_radius));
}

double reachOf(const MapNode& node, const SameThing& rule) {
  return rule.gate + 2 * kPatchSigmas * std::sqrt(std::max(node.belief.cov.trace(), 0.0));
}

bool isOtherName(const MapNode& strong, const MapNode& weak, double sigma_floor) {
  const double own = weightOf(weak.classes.views, weak.label);
  return strong.label != weak.label && isConfirmed(strong) && weightOf(strong.classes.views, strong.label) > own &&
         weightOf(weak.classes.views, strong.label) > kAlsoCalled * own && reaches(strong.belief, weak.belief.mean) &&
         shareOn(strong, weak, sigma_floor) > kSameSurface;
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
