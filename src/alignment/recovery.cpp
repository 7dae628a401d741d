#include "alignment/recovery.h"

#include <algorithm>
#include <utility>

#include "core/units.h"
#include "creation/object_graph.h"

namespace hgg {
namespace {

/// Places of the search that are aligned: its grid is coarse, so that the right one need not be the first.
constexpr std::size_t kPlaces = 4;
/// Rounds of creation and alignment from one start: the first brings it within reach of its leaves' partners.
constexpr int kRounds = 3;
/// Standard deviations of a start: a cell of the search, in leaf sizes, and its step of yaw.
constexpr double kStartLeaves = 1.5, kStartTurn = 2 * kDegree;
/// The best place has this many times the leaves on the map that any place elsewhere has.
constexpr double kClearly = 1.1;
/// The map knows this share of the frame's upright leaves at least, or the frame shows another place.
constexpr double kKnownShare = 0.3;
/// Farthest that the frame is looked at, m: what lies beyond tells the yaw, which what is nearer tells well enough.
constexpr double kSearchRadius = 60;

PoseBelief startAt(const Pose& T_map_body, double leaf_size) {
  Vec6 deviations;
  deviations << Vec3::Constant(kStartLeaves * leaf_size), Vec3::Constant(kStartTurn);
  return {T_map_body, deviations.cwiseAbs2().cwiseInverse().asDiagonal()};
}

/// The upright leaves of the frame, whether or not the map knows their objects.
double uprightIn(const Recovery& found) {
  double upright = 0;
  for (const LocalObject& object : found.local.objects) {
    const Mat3 R = (found.alignment.pose.T_map_body * object.T_body_object).linear();
    for (const LocalLeaf& leaf : object.leaves) {
      upright += hasExtent(leaf) && isUpright(R * leaf.cov * R.transpose()) ? 1 : 0;
    }
  }
  return upright;
}

}  // namespace

Recovery alignFrom(const Pose& T_map_start, const Frame& frame, const Map& map, const ClassTable& classes,
                   const Config& config) {
  Recovery found;
  PoseBelief prior = startAt(T_map_start, config.map.leaf_size);
  for (int round = 0; round < kRounds; ++round) {
    found.local = createLocalGraph(frame, prior.T_map_body, classes, config);
    found.alignment = align(found.local, map, prior, config);
    prior.T_map_body = found.alignment.pose.T_map_body;
  }
  return found;
}

bool isFoundAt(const Pose& T_map_body, const LocalGraph& local, const Map& map, const SearchReach& reach,
               const Config& config) {
  const double radius = std::min(kSearchRadius, config.frame.range_max), leaf_size = config.map.leaf_size;
  const std::vector<Pose> places = searchPoses(local, map, T_map_body, reach, radius, leaf_size, 1);
  if (places.empty()) {
    return false;
  }
  const Pose off = T_map_body.inverse() * places.front();
  return off.translation().norm() < 2 * kStartLeaves * leaf_size && turnOf(off) < 2 * kStartTurn;
}

bool fitsClearlyBetter(const Fit& a, const Fit& b) { return a.fitting > kClearly * b.fitting; }

std::optional<Recovery> recover(const Frame& frame, const Map& map, const std::vector<Pose>& guesses,
                                const SearchReach& reach, double least_share, const ClassTable& classes,
                                const Config& config) {
  const LocalGraph local = createLocalGraph(frame, guesses.front(), classes, config);
  std::vector<Pose> starts =
      searchPoses(local, map, guesses.front(), reach, std::min(kSearchRadius, config.frame.range_max),
                  config.map.leaf_size, kPlaces);
  starts.insert(starts.begin(), guesses.begin(), guesses.end());
  std::vector<Recovery> found;
  for (const Pose& start : starts) {
    found.push_back(alignFrom(start, frame, map, classes, config));
  }
  const auto fitting = [](const Recovery& r) { return r.alignment.fit.fitting; };
  const auto best = std::ranges::max_element(found, {}, fitting);
  const auto isRival = [&](const Recovery& r) {
    return areDistinctPoses(r.alignment.pose.T_map_body, best->alignment.pose.T_map_body) &&
           !fitsClearlyBetter(best->alignment.fit, r.alignment.fit);
  };
  const Fit& fit = best->alignment.fit;
  const auto stride =
      static_cast<double>(leafStride(best->local, best->alignment.pairs, config.alignment.max_leaf_pairs));
  const bool is_known = UsualFit::canTell(fit) && stride * fit.known >= kKnownShare * uprightIn(*best);
  if (!is_known || fit.share() < least_share || std::ranges::any_of(found, isRival)) {
    return std::nullopt;
  }
  return std::move(*best);
}

}  // namespace hgg
