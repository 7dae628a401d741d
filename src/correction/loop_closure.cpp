#include "correction/loop_closure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr std::size_t kDistanceBins = 8;
constexpr std::size_t kMostThings = 60;  // of a place; the nearest

/// How far a place reaches, as a share of the radius within which a frame meets the map.
constexpr double kPartShare = 0.4, kDescriptorShare = 0.25;
/// Two passes of one place may be this far apart.
constexpr double kPassShare = 0.1;
constexpr double kDriftBound = 3;           // standard deviations
constexpr double kTurnSlack = 3 * kDegree;  // of the prior, on top of drift
constexpr std::size_t kFewestThings = 4;

/// What verification leaves open, as shares of a leaf's size and in turn: the worst of twenty right answers.
constexpr double kLoopSigmaShare = 0.2, kLoopTurn = 0.3 * kDegree;

std::vector<const MapNode*> thingsAround(const Map& map, const Vec3& centre, double radius) {
  std::vector<std::pair<double, const MapNode*>> found;
  for (const NodeId id : map.near(centre, radius)) {
    const MapNode& node = *map.find(id);
    if (!node.stuff && isConfirmed(node)) {
      found.emplace_back((node.belief.mean - centre).norm(), &node);
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  found.resize(std::min(found.size(), kMostThings));
  std::vector<const MapNode*> things;
  for (const auto& [distance, node] : found) {
    things.push_back(node);
  }
  return things;
}

std::size_t pairBucket(ClassId a, ClassId b) {
  const std::uint32_t low = std::min(a, b), high = std::max(a, b);
  return ((low * 0x9E3779B1U) ^ (high * 0x85EBCA77U)) >> 28U;  // the upper bits know all of both
}

double partRadius(const Config& config) { return kPartShare * config.map.active_radius; }

/// A map of its own of the nodes that lie around a place.
Map partOf(const Map& map, const Vec3& centre, double radius, bool active) {
  std::vector<MapNode> nodes;
  for (const NodeId id : map.nearAnywhere(centre, radius)) {
    const MapNode& node = *map.find(id);
    if (map.isActive(node) == active) {
      nodes.push_back(node);
      nodes.back().anchor = -1;
    }
  }
  return Map::restore(std::move(nodes), {}, map.classNames(), 0);
}

bool hasThings(const Map& part) {
  return std::ranges::count_if(part.nodes(), [](const auto& entry) {
           return !entry.second.stuff && isConfirmed(entry.second);
         }) >= static_cast<std::ptrdiff_t>(kFewestThings);
}

/// A keyframe out of reach that may show where the last one is.
struct RankedKeyframe {
  KeyframeId id = -1;
  double score = -1;
  Drift drift;
};

RankedKeyframe bestCandidate(const Map& map, const std::vector<PlaceDescriptor>& descriptors, const Config& config) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  const Vec3 here = poses.back().T_map_body.translation();
  const auto isReached = [&](std::size_t k) { return map.isActive(static_cast<KeyframeId>(k)); };
  std::size_t reached = 0;
  while (reached < poses.size() && isReached(reached)) {
    ++reached;
  }
  if (reached == poses.size()) {
    return {};  // there is nothing to find again
  }
  const auto drift = map.keyframes().driftFrom(map.keyframes().last(), std::numeric_limits<double>::infinity());
  RankedKeyframe best;
  for (std::size_t k = 0; k + 1 < poses.size(); ++k) {
    const double distance = (poses[k].T_map_body.translation() - here).norm();
    const double allowed = kDriftBound * drift[k].position + kPassShare * config.map.active_radius;
    if (isReached(k) || drift[k].position < 0 || distance > allowed) {
      continue;
    }
    const double nearness = 1 - distance / allowed;
    const double likeness = k < descriptors.size() ? similarityOf(descriptors[k], descriptors.back()) : 0;
    const double score = allowed < partRadius(config) ? nearness : likeness;
    if (score > best.score) {
      best = {static_cast<KeyframeId>(k), score, drift[k]};
    }
  }
  return best;
}

/// How far the keyframes lie from where a loop has them, as a norm that has six degrees of freedom.
double deviationsOf(const LoopCandidate& q, const BetweenConstraint& loop) {
  const Pose T_before_now = q.keyframe_before.T_map_body.inverse() * q.keyframe_now.T_map_body;
  const Pose off = loop.T_a_b.inverse() * T_before_now;
  const double turn = turnOf(off);
  return std::hypot(off.translation().norm() / std::hypot(q.drift.position, loop.sigma),
                    turn / std::hypot(q.drift.turn, loop.sigma_turn));
}

}  // namespace

PlaceDescriptor describePlace(const Map& map, const Vec3& centre, double radius) {
  const std::vector<const MapNode*> things = thingsAround(map, centre, radius);
  PlaceDescriptor histogram{};
  for (std::size_t i = 0; i < things.size(); ++i) {
    for (std::size_t j = i + 1; j < things.size(); ++j) {
      const double distance = (things[i]->belief.mean - things[j]->belief.mean).norm() / radius;
      const auto bin = static_cast<std::size_t>(distance * kDistanceBins);
      if (bin < kDistanceBins) {
        histogram[pairBucket(things[i]->label, things[j]->label) * kDistanceBins + bin] += 1;
      }
    }
  }
  float square = 0;
  for (const float v : histogram) {
    square += v * v;
  }
  for (float& v : histogram) {
    v /= std::max(std::sqrt(square), 1e-6F);
  }
  return histogram;
}

double similarityOf(const PlaceDescriptor& a, const PlaceDescriptor& b) {
  double product = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    product += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  }
  return product;
}

double descriptorRadius(const Config& config) { return kDescriptorShare * config.map.active_radius; }

std::optional<LoopCandidate> findLoopCandidate(const Map& map, const std::vector<PlaceDescriptor>& descriptors,
                                               const Config& config) {
  const RankedKeyframe best = bestCandidate(map, descriptors, config);
  if (best.id < 0) {
    return std::nullopt;
  }
  LoopCandidate question;
  question.before_id = best.id, question.now_id = map.keyframes().last();
  question.keyframe_before = map.keyframes().poses()[static_cast<std::size_t>(best.id)];
  question.keyframe_now = map.keyframes().poses().back();
  const Vec3 here = question.keyframe_now.T_map_body.translation();
  const Vec3 there = question.keyframe_before.T_map_body.translation();
  question.before = partOf(map, there, partRadius(config), false);
  question.now = partOf(map, here, partRadius(config), true);
  question.drift = best.drift;
  question.prior.centre_b = here;
  question.prior.distance = kDriftBound * best.drift.position + 0.5 * config.alignment.gate;
  question.prior.turn = kDriftBound * best.drift.turn + kTurnSlack;
  return hasThings(question.before) && hasThings(question.now) ? std::optional(std::move(question)) : std::nullopt;
}

LoopVerification verifyLoop(const LoopCandidate& q, std::span<const SimilarClasses> similar, const Config& config) {
  LoopVerification answer;
  answer.alignment = alignMaps(q.before, q.now, similar, q.prior);
  const Pose T_before_now = q.keyframe_before.T_map_body.inverse() * answer.alignment.T_a_b * q.keyframe_now.T_map_body;
  answer.loop = {q.before_id, q.now_id, T_before_now, kLoopSigmaShare * config.map.leaf_size, kLoopTurn, true};
  answer.deviations = deviationsOf(q, answer.loop);
  return answer;
}

}  // namespace hgg
