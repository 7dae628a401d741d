#include "correction/loop_closure.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "core/se3.h"
#include "core/units.h"

namespace hgg {
namespace {

constexpr std::size_t kDistanceBins = 8;
constexpr std::size_t kMostThings = 60;  // that describe a place: the nearest

/// Sizes of a place in tiles: what is compared, what is described, and how far apart two passes of it may be.
constexpr double kPlaceTiles = 4, kDescriptorTiles = 2.5, kPassTiles = 1;
constexpr double kDriftBound = 3;  // standard deviations
/// How far beyond drift verification looks: half the distance at which a frame's things find their partners, and a
/// turn.
constexpr double kSlackGates = 0.5, kTurnSlack = 3 * kDegree;
constexpr std::size_t kFewestThings = 4;
/// Places that are looked at where only their looks can tell: the right one need not look most alike.
constexpr std::size_t kMostPlaces = 3;

/// Error of a verified loop in leaf sizes and rad: the largest of twenty right ones.
constexpr double kLoopSigmaLeaves = 0.2, kLoopTurn = 0.3 * kDegree;
/// Two loops of one place agree when they differ by no more than each of them may be off: half a leaf, because leaves
/// register it, together with the error of a thing's centroid (ObservationNoise::view_noise, m); and a degree (rad).
/// Outdoors that is 0.29 m. False loops hardly agree so well: one of two parts that meet at their rims or slide along a
/// street was off by a metre.
constexpr double kAgreeLeaves = 0.5, kAgreeNoise = 0.05, kAgreeTurn = 0.0175;

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

/// The inactive nodes around a place that are paged out, where they are now.
void readPages(const Map& map, const Vec3& centre, double radius, const PageReader& pages,
               std::vector<MapNode>& nodes) {
  for (const KeyframeId id : map.pagedOutNear(centre, radius)) {
    Result<MapPage> page = map.isActive(id) ? Result<MapPage>::fail("") : pages(id);
    if (!page) {
      continue;
    }
    const Pose& T_map_keyframe = map.keyframes().poses()[static_cast<std::size_t>(id)].T_map_body;
    const Pose move = orthonormalized(T_map_keyframe * page->T_map_keyframe.inverse());
    for (MapNode& node : page->nodes) {
      moveBy(move, map.tileSize(), node);
      if ((node.belief.mean - centre).norm() <= radius) {
        nodes.push_back(std::move(node));
        nodes.back().anchor = -1;
      }
    }
  }
}

/// A map of its own that holds the active (or the inactive) nodes around a place.
Map partOf(const Map& map, const Vec3& centre, double radius, bool active, const PageReader& pages = nullptr) {
  std::vector<MapNode> nodes;
  for (const NodeId id : map.nearAnywhere(centre, radius)) {
    const MapNode& node = *map.find(id);
    if (map.isActive(node) == active) {
      nodes.push_back(node);
      nodes.back().anchor = -1;
    }
  }
  if (!active && pages) {
    readPages(map, centre, radius, pages, nodes);
  }
  return Map::restore(std::move(nodes), {}, map.classNames(), 0);
}

bool hasThings(const Map& part) {
  return std::ranges::count_if(part.nodes(), [](const auto& entry) {
           return !entry.second.stuff && isConfirmed(entry.second);
         }) >= static_cast<std::ptrdiff_t>(kFewestThings);
}

bool isAllActive(const Map& map) {
  KeyframeId k = map.keyframes().last();
  while (k >= 0 && map.isActive(k)) {
    --k;
  }
  return k < 0;
}

struct ScoredKeyframe {
  LoopKeyframe keyframe;
  double score = 0;
};

/// The `count` best of the keyframes that lie this far apart, m. Of equally good ones the oldest.
std::vector<LoopKeyframe> bestDistinct(const std::vector<TimedPose>& poses, std::vector<ScoredKeyframe> scored,
                                       std::size_t count, double apart) {
  std::ranges::stable_sort(scored, std::greater<>(), &ScoredKeyframe::score);
  std::vector<LoopKeyframe> best;
  const auto placeOf = [&](const LoopKeyframe& k) -> Vec3 {
    return poses[static_cast<std::size_t>(k.id)].T_map_body.translation();
  };
  for (const ScoredKeyframe& candidate : scored) {
    const Vec3 place = placeOf(candidate.keyframe);
    const auto isNear = [&](const LoopKeyframe& k) { return (placeOf(k) - place).norm() < apart; };
    if (best.size() < count && std::ranges::none_of(best, isNear)) {
      best.push_back(candidate.keyframe);
    }
  }
  return best;
}

/// How far the keyframes lie from where the loop puts them, in standard deviations (a chi norm of six degrees of
/// freedom).
double deviationsOf(const LoopCandidate& candidate, const BetweenConstraint& loop) {
  const Pose T_before_now = candidate.keyframe_before.T_map_body.inverse() * candidate.keyframe_now.T_map_body;
  const Pose off = loop.T_a_b.inverse() * T_before_now;
  const double turn = turnOf(off);
  return std::hypot(off.translation().norm() / std::hypot(candidate.drift.position, loop.sigma),
                    turn / std::hypot(candidate.drift.turn, loop.sigma_turn));
}

}  // namespace

LoopConfig loopConfigOf(double tile_size, double leaf_size, double gate) {
  LoopConfig config;
  config.descriptor_radius = kDescriptorTiles * tile_size;
  config.place_radius = kPlaceTiles * tile_size;
  config.pass_distance = kPassTiles * tile_size;
  config.prior_slack = kSlackGates * gate;
  config.prior_turn_slack = kTurnSlack;
  config.sigma = kLoopSigmaLeaves * leaf_size;
  config.sigma_turn = kLoopTurn;
  config.agree_distance = std::numbers::sqrt2 * std::hypot(kAgreeLeaves * leaf_size, kAgreeNoise);
  config.agree_turn = kAgreeTurn;
  return config;
}

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

namespace {

/// Keyframes that are looked at at a time, where there are more; and the drift from one of them is used for so many
/// further ones.
constexpr std::size_t kLookedAt = 2000;
constexpr KeyframeId kDriftKept = 400;
/// Keyframes this many places' radii away are always looked at.
constexpr double kNearPlaces = 5;

/// The keyframes to look at, ascending.
std::vector<KeyframeId> lookedAt(const Map& map, const Vec3& here, const LoopConfig& config, LoopSearch& search) {
  const std::size_t count = map.keyframes().poses().size();
  std::vector<KeyframeId> ids;
  if (count > kLookedAt) {
    ids = map.keyframesNear(here, kNearPlaces * config.place_radius);
    search.next = search.next < count ? search.next : 0;
  } else {
    search.next = 0;
  }
  const std::size_t end = std::min(search.next + kLookedAt, count);
  for (std::size_t k = search.next; k < end; ++k) {
    ids.push_back(static_cast<KeyframeId>(k));
  }
  search.next = end;
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

/// Drift from the current keyframe to others.
class DriftTo {
 public:
  DriftTo(const KeyframeGraph& keyframes, LoopSearch& search) : keyframes_(keyframes), search_(search) {
    const KeyframeId current = keyframes.current();
    const bool is_small = keyframes.poses().size() <= kLookedAt;
    if (is_small || search.from < 0 || keyframes.last() - static_cast<KeyframeId>(search.drift.size()) >= kDriftKept) {
      search.drift = keyframes.driftFrom(current, std::numeric_limits<double>::infinity());
      search.from = current;
    } else if (current != search.from) {
      to_from_ = keyframes.driftFromTo(current, search.from);
    }
  }
  /// Negative: nothing leads there.
  Drift operator()(KeyframeId id) const {
    const auto k = static_cast<std::size_t>(id);
    if (k >= search_.drift.size() || search_.drift[k].position < 0 || to_from_.position < 0) {
      return {-1, 0};
    }
    const Drift& beyond = search_.drift[k];
    if (to_from_.position == 0) {
      return beyond;
    }
    const auto placeOf = [&](KeyframeId at) -> Vec3 {
      return keyframes_.poses()[static_cast<std::size_t>(at)].T_map_body.translation();
    };
    const double arm = (placeOf(id) - placeOf(search_.from)).norm();
    return {std::hypot(to_from_.position + to_from_.turn * arm, beyond.position),
            std::hypot(to_from_.turn, beyond.turn)};
  }

 private:
  const KeyframeGraph& keyframes_;
  const LoopSearch& search_;
  Drift to_from_;
};

}  // namespace

std::vector<LoopKeyframe> findLoopKeyframes(const Map& map, const std::vector<PlaceDescriptor>& descriptors,
                                            const LoopConfig& config, LoopSearch& search) {
  const std::vector<TimedPose>& poses = map.keyframes().poses();
  const KeyframeId current = map.keyframes().current();
  const Vec3 here = map.keyframes().currentPose().T_map_body.translation();
  if (isAllActive(map)) {
    return {};  // there is nothing to find again
  }
  const DriftTo driftTo(map.keyframes(), search);
  std::vector<ScoredKeyframe> scored;
  bool is_drift_small = false;
  for (const KeyframeId id : lookedAt(map, here, config, search)) {
    if (map.isActive(id)) {
      continue;
    }
    const auto k = static_cast<std::size_t>(id);
    const Drift drift = driftTo(id);
    const double distance = (poses[k].T_map_body.translation() - here).norm();
    const double allowed = kDriftBound * drift.position + config.pass_distance;
    if (drift.position < 0 || distance > allowed) {
      continue;
    }
    const double nearness = 1 - distance / allowed;
    const double likeness =
        k < descriptors.size() ? similarityOf(descriptors[k], descriptors[static_cast<std::size_t>(current)]) : 0;
    const bool is_near = allowed < config.place_radius;
    is_drift_small |= is_near;
    scored.push_back({{id, drift}, is_near ? nearness : likeness});
  }
  return bestDistinct(poses, std::move(scored), is_drift_small ? 1 : kMostPlaces, config.place_radius / 2);
}

std::optional<LoopCandidate> cutLoopCandidate(const Map& map, const LoopKeyframe& keyframe, const LoopConfig& config,
                                              const PageReader& pages) {
  LoopCandidate candidate;
  candidate.before_id = keyframe.id, candidate.now_id = map.keyframes().current();
  candidate.keyframe_before = map.keyframes().poses()[static_cast<std::size_t>(keyframe.id)];
  candidate.keyframe_now = map.keyframes().currentPose();
  const Vec3 here = candidate.keyframe_now.T_map_body.translation();
  const Vec3 there = candidate.keyframe_before.T_map_body.translation();
  candidate.before = partOf(map, there, config.place_radius, false, pages);
  candidate.now = partOf(map, here, config.place_radius, true);
  candidate.drift = keyframe.drift;
  candidate.prior.centre_b = here;
  candidate.prior.distance = kDriftBound * keyframe.drift.position + config.prior_slack;
  candidate.prior.turn = kDriftBound * keyframe.drift.turn + config.prior_turn_slack;
  return hasThings(candidate.before) && hasThings(candidate.now) ? std::optional(std::move(candidate)) : std::nullopt;
}

LoopVerification verifyLoop(const LoopCandidate& candidate, std::span<const SimilarClasses> similar,
                            const LoopConfig& config) {
  LoopVerification found;
  found.alignment = alignMaps(candidate.before, candidate.now, similar, candidate.prior);
  const Pose T_before_now =
      candidate.keyframe_before.T_map_body.inverse() * found.alignment.T_a_b * candidate.keyframe_now.T_map_body;
  found.loop = {candidate.before_id, candidate.now_id, T_before_now, config.sigma, config.sigma_turn, true};
  found.deviations = deviationsOf(candidate, found.loop);
  return found;
}

}  // namespace hgg
