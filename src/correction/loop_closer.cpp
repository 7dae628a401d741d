#include "correction/loop_closer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <span>
#include <utility>

#include "core/se3.h"
#include "correction/pose_graph.h"
#include "place/consistency.h"

namespace hgg {
namespace {

/// The number of keyframes after which a verification's result is taken.
constexpr std::int64_t kResultAfter = 2;
constexpr std::size_t kMostRecords = 1000;
/// Stored keyframes that are nearer to each other than this share of the descriptor's radius share a descriptor.
constexpr double kSamePlaceShare = 0.2;
/// 99 % of true loops lie nearer to where the keyframes were (chi, six degrees of freedom).
constexpr double kMostDeviations = 4.1;
/// A loop that the pose graph gives less weight is taken for a false one.
constexpr double kTrusted = 0.5;
/// A keyframe that a loop would move by less stays where it is, so that its nodes are not published again: m, rad.
constexpr double kStill = 1e-4, kStillTurn = 1e-6;

std::vector<Pose> posesOf(const KeyframeGraph& graph) {
  std::vector<Pose> poses;
  poses.reserve(graph.poses().size());
  for (const TimedPose& k : graph.poses()) {
    poses.push_back(k.T_map_body);
  }
  return poses;
}

bool isElsewhere(const Pose& a, const Pose& b) {
  const Pose off = a.inverse() * b;
  return off.translation().norm() > kStill || turnOf(off) > kStillTurn;
}

/// Moves the keyframes there are now as the loop moves those the candidate knew: other corrections may have moved them
/// since.
MapCorrection correctionOf(const std::vector<Pose>& moves, const Map& map, std::vector<BetweenConstraint> loops) {
  MapCorrection correction;
  correction.loops = std::move(loops);
  const std::vector<TimedPose>& now = map.keyframes().poses();
  for (std::size_t k = 0; k < now.size(); ++k) {
    const Pose T_map_body = orthonormalized(moves[std::min(k, moves.size() - 1)] * now[k].T_map_body);
    if (isElsewhere(T_map_body, now[k].T_map_body)) {
      correction.moved.emplace_back(static_cast<KeyframeId>(k), T_map_body);
    }
  }
  return correction;
}

/// A graph of this many keyframes is copied when a loop is looked at, so that it is solved on the spot when that is
/// recognised. Of a larger one the copy would hold up the frame: it waits until there is something to solve.
constexpr std::size_t kCopiedAhead = 2000;

std::optional<KeyframeGraph> copyToSolve(const KeyframeGraph& graph) {
  return graph.poses().size() <= kCopiedAhead ? std::optional(graph) : std::nullopt;
}

/// Whether the pose graph has found poses at all and gives each of the newest loops enough weight.
bool isTrusted(const PoseGraphSolution& solved, std::size_t newest) {
  return std::isfinite(solved.cost_after) && (solved.converged || solved.cost_after < solved.cost_before) &&
         solved.loop_weights.size() >= newest &&
         std::all_of(solved.loop_weights.end() - static_cast<std::ptrdiff_t>(newest), solved.loop_weights.end(),
                     [](double weight) { return weight > kTrusted; });
}

/// Where the solver starts: a fragment of map whose place was unknown is laid, as a whole, where the loop says. The
/// turn may be of any size, which is too far for a solver that goes by derivatives.
std::vector<Pose> startOf(const KeyframeGraph& graph, const BetweenConstraint& loop) {
  std::vector<Pose> poses = posesOf(graph);
  const std::vector<KeyframeId> fragments = graph.fragments();
  const auto a = static_cast<std::size_t>(loop.a), b = static_cast<std::size_t>(loop.b);
  if (fragments[a] == fragments[b]) {
    return poses;
  }
  const Pose T_here_there = poses[a] * loop.T_a_b * poses[b].inverse();
  const bool moves_a = fragments[b] == 0;  // the first keyframe is where the map's frame is
  const KeyframeId moving = fragments[moves_a ? a : b];
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (fragments[k] == moving) {
      poses[k] = orthonormalized((moves_a ? T_here_there.inverse() : T_here_there) * poses[k]);
    }
  }
  return poses;
}

/// How the keyframes move by the pose graph with new loops in it, T_map_map; empty when it does not trust them.
std::vector<Pose> movesBy(KeyframeGraph graph, std::span<const BetweenConstraint> loops) {
  const std::vector<Pose> before = posesOf(graph), start = startOf(graph, loops.front());
  for (const BetweenConstraint& loop : loops) {
    graph.connect(loop);
  }
  const PoseGraphSolution solved = solvePoseGraph(start, graph.edges());
  std::vector<Pose> moves;
  for (std::size_t k = 0; k < before.size() && isTrusted(solved, loops.size()); ++k) {
    moves.push_back(orthonormalized(solved.poses[k] * before[k].inverse()));
  }
  return moves;
}

/// The candidate whose places were recognised with the best score, else the last one looked at. Candidates that are
/// recognised at different places rule each other out.
std::pair<LoopVerification, const LoopCandidate*> recognise(const std::vector<LoopCandidate>& candidates,
                                                            const std::vector<SimilarClasses>& similar,
                                                            const LoopConfig& config) {
  std::pair<LoopVerification, const LoopCandidate*> best;
  for (const LoopCandidate& candidate : candidates) {
    LoopVerification found = verifyLoop(candidate, similar, config);
    const Vec3& centre = candidate.prior.centre_b;
    const bool both = best.second != nullptr && best.first.alignment.accepted && found.alignment.accepted;
    if (both && areDistinct(best.first.alignment.T_a_b, found.alignment.T_a_b, centre)) {
      found.alignment.accepted = false;
      found.alignment.reason = "ambiguous: recognised at two places";
      return {found, &candidate};
    }
    if (best.second == nullptr || !best.first.alignment.accepted ||
        (found.alignment.accepted && found.alignment.score > best.first.alignment.score)) {
      best = {std::move(found), &candidate};
    }
  }
  return best;
}

LoopRecord failedRecord(Micros before_us, Micros now_us, const std::exception& error) {
  LoopRecord record;
  record.before_us = before_us, record.now_us = now_us;
  record.reason = std::string("could not be looked at: ") + error.what();
  return record;
}

}  // namespace

LoopCloser::Outcome LoopCloser::verify(const std::vector<LoopCandidate>& candidates, std::optional<KeyframeGraph> graph,
                                       const std::vector<SimilarClasses>& similar, const LoopConfig& config) {
  const auto& [found, candidate] = recognise(candidates, similar, config);
  Outcome outcome{{found.loop, found.deviations}, found.alignment.accepted, {}, {}, true};
  outcome.record = {candidate->keyframe_before.utime_us,
                    candidate->keyframe_now.utime_us,
                    found.alignment.accepted,
                    found.alignment.score,
                    found.deviations,
                    found.loop.T_a_b,
                    found.alignment.reason};
  if (outcome.record.accepted && found.deviations > kMostDeviations) {
    outcome.record.accepted = false;
    outcome.record.reason = "farther off than drift allows: " + outcome.record.reason;
  }
  outcome.is_laid_out = graph.has_value() || !outcome.record.accepted;
  return outcome.is_laid_out && outcome.record.accepted ? layOut(std::move(outcome), std::move(*graph)) : outcome;
}

LoopCloser::Outcome LoopCloser::layOut(Outcome outcome, KeyframeGraph graph) {
  outcome.is_laid_out = true;
  outcome.moves = movesBy(std::move(graph), {&outcome.verified.loop, 1});
  if (outcome.moves.empty()) {
    outcome.record.accepted = false;
    outcome.record.reason = "the other keyframes speak against it: " + outcome.record.reason;
  }
  return outcome;
}

LoopCloser::Outcome LoopCloser::verifySafely(const std::vector<LoopCandidate>& candidates,
                                             std::optional<KeyframeGraph> graph,
                                             const std::vector<SimilarClasses>& similar, const LoopConfig& config) {
  try {
    return verify(candidates, std::move(graph), similar, config);
  } catch (const std::exception& error) {
    const LoopCandidate& first = candidates.front();
    return {{}, false, failedRecord(first.keyframe_before.utime_us, first.keyframe_now.utime_us, error), {}, true};
  }
}

bool LoopCloser::isVerificationDue() const {
  if (!verification_.valid() || steps_ < picked_at_ + kResultAfter) {
    return false;
  }
  return timing_ == LoopTiming::kFixed || verification_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void LoopCloser::describe(const Map& map) {
  const KeyframeGraph& keyframes = map.keyframes();
  const Vec3 here = keyframes.currentPose().T_map_body.translation();
  descriptors_.resize(keyframes.poses().size());
  descriptors_[static_cast<std::size_t>(keyframes.current())] = describePlace(map, here, config_.descriptor_radius);
}

void LoopCloser::start(const Map& stored) {
  const double radius = config_.descriptor_radius;
  Vec3 described = Vec3::Zero();
  for (const TimedPose& k : stored.keyframes().poses()) {
    const Vec3 here = k.T_map_body.translation();
    if (descriptors_.empty() || (here - described).norm() > kSamePlaceShare * radius) {
      descriptors_.push_back(describePlace(stored, here, radius));
      described = here;
    } else {
      descriptors_.push_back(descriptors_.back());
    }
  }
}

std::optional<MapCorrection> LoopCloser::step(const Map& map) {
  ++steps_;
  describe(map);
  auto correction = isVerificationDue() ? take(map, false) : std::nullopt;
  if (!correction && !verification_.valid()) {
    picked_ = findLoopKeyframes(map, descriptors_, config_, search_);
  }
  return correction;
}

std::optional<MapCorrection> LoopCloser::take(const Map& map, bool is_last) {
  if (!verification_.valid()) {
    return std::nullopt;
  }
  Outcome outcome = verification_.get();
  if (!outcome.is_laid_out) {
    picked_at_ = steps_;
    verification_ = std::async(std::launch::async, [outcome = std::move(outcome), graph = map.keyframes()]() mutable {
      return layOut(std::move(outcome), std::move(graph));
    });
    return is_last ? take(map, true) : std::nullopt;
  }
  std::optional<MapCorrection> correction;
  if (outcome.is_recognised) {
    agreement_.add(outcome.verified);
    const bool is_confirmed = !agreement_.agreeingWithNewest(map.keyframes()).empty();
    if (outcome.record.accepted && is_confirmed) {
      correction = correctionOf(outcome.moves, map, {outcome.verified.loop});
    } else if (correction = overruled(map); correction) {
      outcome.record.reason = "three loops agree against what was believed: " + outcome.record.reason;
    } else if (outcome.record.accepted) {
      outcome.record.reason = "not seen twice yet: " + outcome.record.reason;
    }
    outcome.record.accepted = correction.has_value();
  }
  if (correction) {
    agreement_.clear();
    search_ = {};  // the loop has changed the drift
  }
  record(outcome.record);
  return correction;
}

std::optional<MapCorrection> LoopCloser::overruled(const Map& map) const {
  const std::vector<VerifiedLoop> loops = agreement_.overruling(map.keyframes());
  if (loops.empty()) {
    return std::nullopt;
  }
  KeyframeGraph graph = map.keyframes();
  const Loosening loosening = looseningFor(loops);
  graph.loosen(loosening);
  std::vector<BetweenConstraint> constraints;
  for (const VerifiedLoop& verified : loops) {
    constraints.push_back(verified.loop);
  }
  const std::vector<Pose> moves = movesBy(std::move(graph), constraints);
  if (moves.empty()) {
    return std::nullopt;
  }
  MapCorrection correction = correctionOf(moves, map, std::move(constraints));
  correction.loosened = loosening;
  return correction;
}

void LoopCloser::record(const LoopRecord& record) {
  ++(record.accepted ? accepted_ : rejected_);
  records_.push_back(record);
  if (records_.size() > kMostRecords) {
    records_.pop_front();
  }
}

void LoopCloser::startVerification(const Map& map, const PageReader& pages) {
  const std::vector<LoopKeyframe> keyframes = std::exchange(picked_, {});
  try {
    std::vector<LoopCandidate> candidates;
    for (const LoopKeyframe& keyframe : keyframes) {
      if (auto candidate = cutLoopCandidate(map, keyframe, config_, pages)) {
        candidates.push_back(std::move(*candidate));
      }
    }
    if (!candidates.empty()) {
      verification_ =
          std::async(std::launch::async,
                     [candidates = std::move(candidates), graph = copyToSolve(map.keyframes()), similar = similar_,
                      config = config_] { return verifySafely(candidates, graph, similar, config); });
      picked_at_ = steps_;
    }
  } catch (const std::exception& error) {  // no memory, no thread
    const Micros now_us = map.keyframes().currentPose().utime_us;
    record(failedRecord(now_us, now_us, error));
  }
}

}  // namespace hgg
