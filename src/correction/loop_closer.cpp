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

constexpr KeyframeId kAnswerAfter = 2;  // keyframes
constexpr std::size_t kMostRecords = 1000;
/// Stored keyframes that are nearer to each other, in radii of what is described, share a description.
constexpr double kSamePlaceShare = 0.2;
/// 99 % of true ones lie nearer to where the keyframes were (chi, six degrees of freedom).
constexpr double kMostDeviations = 4.1;
/// Two loops of one place that agree so well (a share of the gate of alignment, rad) are not both chance. One alone, of
/// two parts that meet at their rims or slide along a street, was off by a metre.
constexpr double kAgreeShare = 0.1, kAgreeTurn = 0.0175;
/// A loop that the pose graph trusts less is none.
constexpr double kTrusted = 0.5;
/// What a loop moves by less stays, and is not sent to anyone.
constexpr double kStill = 1e-4, kStillTurn = 1e-6;  // m, rad

std::vector<PoseGraphEdge> edgesOf(const KeyframeGraph& graph) {
  std::vector<PoseGraphEdge> edges;
  edges.reserve(graph.edges().size() + 1);
  for (const BetweenConstraint& e : graph.edges()) {
    PoseGraphEdge edge{e.a, e.b, e.T_a_b, Mat6::Zero(), e.is_loop};
    edge.information.diagonal() << Vec3::Constant(1 / (e.sigma * e.sigma)),
        Vec3::Constant(1 / (e.sigma_turn * e.sigma_turn));
    edges.push_back(edge);
  }
  return edges;
}

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

/// Brings the keyframes there are now to where a loop moves them. They may have been moved otherwise since it was
/// asked.
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

/// Whether the pose graph has found poses at all, and believes the newest loop in them.
bool isTrusted(const PoseGraphSolution& solved) {
  return std::isfinite(solved.cost_after) && (solved.converged || solved.cost_after < solved.cost_before) &&
         !solved.loop_weights.empty() && solved.loop_weights.back() > kTrusted;
}

LoopRecord notLookedAt(Micros before_us, Micros now_us, const std::exception& error) {
  LoopRecord record;
  record.before_us = before_us, record.now_us = now_us;
  record.reason = std::string("could not be looked at: ") + error.what();
  return record;
}

}  // namespace

LoopCloser::Closure LoopCloser::close(const LoopCandidate& question, KeyframeGraph graph,
                                      const std::vector<SimilarClasses>& similar, const Config& config) {
  const LoopVerification answer = verifyLoop(question, similar, config);
  Closure closure{answer.loop, {}, {}};
  closure.record = {question.keyframe_before.utime_us,
                    question.keyframe_now.utime_us,
                    answer.alignment.accepted,
                    answer.alignment.score,
                    answer.deviations,
                    answer.loop.T_a_b,
                    answer.alignment.reason};
  if (closure.record.accepted && answer.deviations > kMostDeviations) {
    closure.record.accepted = false;
    closure.record.reason = "farther off than drift allows: " + closure.record.reason;
  }
  if (!closure.record.accepted) {
    return closure;
  }
  graph.connect(answer.loop);
  const std::vector<Pose> poses = posesOf(graph);
  const PoseGraphSolution solved = solvePoseGraph(poses, edgesOf(graph));
  if (isTrusted(solved)) {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      closure.moves.push_back(orthonormalized(solved.poses[k] * poses[k].inverse()));
    }
  } else {
    closure.record.accepted = false;
    closure.record.reason = "the other keyframes speak against it: " + closure.record.reason;
  }
  return closure;
}

LoopCloser::Closure LoopCloser::closeSafely(const LoopCandidate& question, KeyframeGraph graph,
                                            const std::vector<SimilarClasses>& similar, const Config& config) {
  try {
    return close(question, std::move(graph), similar, config);
  } catch (const std::exception& error) {
    return {{}, notLookedAt(question.keyframe_before.utime_us, question.keyframe_now.utime_us, error), {}};
  }
}

bool LoopCloser::isDue(const Map& map) const {
  if (!pending_.valid() || map.keyframes().last() < asked_at_ + kAnswerAfter) {
    return false;
  }
  return timing_ == LoopTiming::kFixed || pending_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

void LoopCloser::start(const Map& stored) {
  const double radius = descriptorRadius(config_);
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
  descriptors_.back() = describePlace(map, here, descriptorRadius(config_));
  auto correction = isDue(map) ? finish(map) : std::nullopt;
  if (!correction && !pending_.valid()) {
    ask(map);
  }
  return correction;
}

std::optional<MapCorrection> LoopCloser::finish(const Map& map) {
  if (!pending_.valid()) {
    return std::nullopt;
  }
  Closure closure = pending_.get();
  if (closure.record.accepted && !isConfirmed(map, closure.loop)) {
    closure.record.accepted = false;
    closure.record.reason = "not seen twice yet: " + closure.record.reason;
  }
  record(closure.record);
  return closure.record.accepted ? std::optional(correctionOf(closure.moves, map, closure.loop)) : std::nullopt;
}

bool LoopCloser::isConfirmed(const Map& map, const BetweenConstraint& loop) {
  const auto before = std::exchange(unconfirmed_, loop);
  if (!before) {
    return false;
  }
  const auto poseOf = [&](KeyframeId id) { return map.keyframes().poses()[static_cast<std::size_t>(id)].T_map_body; };
  const Pose expected =
      poseOf(loop.a).inverse() * poseOf(before->a) * before->T_a_b * poseOf(before->b).inverse() * poseOf(loop.b);
  const Pose off = expected.inverse() * loop.T_a_b;
  const bool agrees = off.translation().norm() < kAgreeShare * config_.alignment.gate && turnOf(off) < kAgreeTurn;
  if (agrees) {
    unconfirmed_.reset();
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

void LoopCloser::ask(const Map& map) {
  try {
    if (auto question = findLoopCandidate(map, descriptors_, config_)) {
      pending_ =
          std::async(std::launch::async, [question = std::move(*question), graph = map.keyframes(), similar = similar_,
                                          config = config_] { return closeSafely(question, graph, similar, config); });
      asked_at_ = map.keyframes().last();
    }
  } catch (const std::exception& error) {  // no memory, no thread
    const Micros now_us = map.keyframes().poses().back().utime_us;
    record(notLookedAt(now_us, now_us, error));
  }
}

}  // namespace hgg
