#include "correction/loop_closer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "core/se3.h"
#include "correction/pose_graph.h"

namespace hgg {
namespace {

/// The number of keyframes after which a verification's result is taken.
constexpr KeyframeId kResultAfter = 2;
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
MapCorrection correctionOf(const std::vector<Pose>& moves, const Map& map, const BetweenConstraint& loop) {
  MapCorrection correction{{}, {loop}};
  const std::vector<TimedPose>& now = map.keyframes().poses();
  for (std::size_t k = 0; k < now.size(); ++k) {
    const Pose T_map_body = orthonormalized(moves[std::min(k, moves.size() - 1)] * now[k].T_map_body);
    if (isElsewhere(T_map_body, now[k].T_map_body)) {
      correction.moved.emplace_back(static_cast<KeyframeId>(k), T_map_body);
    }
  }
  return correction;
}

/// Whether the pose graph has found poses at all and gives the newest loop enough weight.
bool isTrusted(const PoseGraphSolution& solved) {
  return std::isfinite(solved.cost_after) && (solved.converged || solved.cost_after < solved.cost_before) &&
         !solved.loop_weights.empty() && solved.loop_weights.back() > kTrusted;
}

LoopRecord failedRecord(Micros before_us, Micros now_us, const std::exception& error) {
  LoopRecord record;
  record.before_us = before_us, record.now_us = now_us;
  record.reason = std::string("could not be looked at: ") + error.what();
  return record;
}

}  // namespace

LoopCloser::Outcome LoopCloser::verify(const LoopCandidate& candidate, KeyframeGraph graph,
                                       const std::vector<SimilarClasses>& similar, const LoopConfig& config) {
  const LoopVerification found = verifyLoop(candidate, similar, config);
  Outcome outcome{found.loop, {}, {}};
  outcome.record = {candidate.keyframe_before.utime_us,
                    candidate.keyframe_now.utime_us,
                    found.alignment.accepted,
                    found.alignment.score,
                    found.deviations,
                    found.loop.T_a_b,
                    found.alignment.reason};
  if (outcome.record.accepted && found.deviations > kMostDeviations) {
    outcome.record.accepted = false;
    outcome.record.reason = "farther off than drift allows: " + outcome.record.reason;
  }
  if (!outcome.record.accepted) {
    return outcome;
  }
  graph.connect(found.loop);
  const std::vector<Pose> poses = posesOf(graph);
  const PoseGraphSolution solved = solvePoseGraph(poses, graph.edges());
  if (isTrusted(solved)) {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      outcome.moves.push_back(orthonormalized(solved.poses[k] * poses[k].inverse()));
    }
  } else {
    outcome.record.accepted = false;
    outcome.record.reason = "the other keyframes speak against it: " + outcome.record.reason;
  }
  return outcome;
}

LoopCloser::Outcome LoopCloser::verifySafely(const LoopCandidate& candidate, KeyframeGraph graph,
                                             const std::vector<SimilarClasses>& similar, const LoopConfig& config) {
  try {
    return verify(candidate, std::move(graph), similar, config);
  } catch (const std::exception& error) {
    return {{}, failedRecord(candidate.keyframe_before.utime_us, candidate.keyframe_now.utime_us, error), {}};
  }
}

bool LoopCloser::isVerificationDue(const Map& map) const {
  if (!verification_.valid() || map.keyframes().last() < candidate_at_ + kResultAfter) {
    return false;
  }
  return timing_ == LoopTiming::kFixed || verification_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
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
  const Vec3 here = map.keyframes().poses().back().T_map_body.translation();
  descriptors_.resize(map.keyframes().poses().size());
  descriptors_.back() = describePlace(map, here, config_.descriptor_radius);
  auto correction = isVerificationDue(map) ? finish(map) : std::nullopt;
  if (!correction && !verification_.valid()) {
    picked_ = findLoopKeyframe(map, descriptors_, config_);
  }
  return correction;
}

std::optional<MapCorrection> LoopCloser::finish(const Map& map) {
  if (!verification_.valid()) {
    return std::nullopt;
  }
  Outcome outcome = verification_.get();
  if (outcome.record.accepted && !agreesWithPrevious(map, outcome.loop)) {
    outcome.record.accepted = false;
    outcome.record.reason = "not seen twice yet: " + outcome.record.reason;
  }
  record(outcome.record);
  return outcome.record.accepted ? std::optional(correctionOf(outcome.moves, map, outcome.loop)) : std::nullopt;
}

bool LoopCloser::agreesWithPrevious(const Map& map, const BetweenConstraint& loop) {
  const auto before = std::exchange(previous_, loop);
  if (!before) {
    return false;
  }
  const auto poseOf = [&](KeyframeId id) { return map.keyframes().poses()[static_cast<std::size_t>(id)].T_map_body; };
  const Pose expected =
      poseOf(loop.a).inverse() * poseOf(before->a) * before->T_a_b * poseOf(before->b).inverse() * poseOf(loop.b);
  const Pose off = expected.inverse() * loop.T_a_b;
  const bool agrees = off.translation().norm() < config_.agree_distance && turnOf(off) < config_.agree_turn;
  if (agrees) {
    previous_.reset();
  }
  return agrees;
}

void LoopCloser::record(const LoopRecord& record) {
  ++(record.accepted ? accepted_ : rejected_);
  records_.push_back(record);
  if (records_.size() > kMostRecords) {
    records_.pop_front();
  }
}

void LoopCloser::startVerification(const Map& map) {
  const auto keyframe = std::exchange(picked_, std::nullopt);
  if (!keyframe) {
    return;
  }
  try {
    if (auto candidate = cutLoopCandidate(map, *keyframe, config_)) {
      verification_ = std::async(std::launch::async,
                                 [candidate = std::move(*candidate), graph = map.keyframes(), similar = similar_,
                                  config = config_] { return verifySafely(candidate, graph, similar, config); });
      candidate_at_ = map.keyframes().last();
    }
  } catch (const std::exception& error) {  // no memory, no thread
    const Micros now_us = map.keyframes().poses().back().utime_us;
    record(failedRecord(now_us, now_us, error));
  }
}

}  // namespace hgg
