#include "correction/loop_agreement.h"

#include <algorithm>
#include <cstdlib>

namespace hgg {
namespace {

constexpr std::size_t kMostLoops = 6;
/// Loops this many keyframes apart (some 60 m of way) are not compared.
constexpr KeyframeId kLately = 30;
/// Loops that overrule the belief, the newest one among them.
constexpr std::size_t kOverruling = 3;

}  // namespace

void LoopAgreement::add(const VerifiedLoop& loop) {
  loops_.push_back(loop);
  if (loops_.size() > kMostLoops) {
    loops_.pop_front();
  }
}

bool LoopAgreement::agree(const KeyframeGraph& keyframes, const BetweenConstraint& a,
                          const BetweenConstraint& b) const {
  const auto poseOf = [&](KeyframeId id) -> const Pose& {
    return keyframes.poses()[static_cast<std::size_t>(id)].T_map_body;
  };
  const Pose expected = poseOf(b.a).inverse() * poseOf(a.a) * a.T_a_b * poseOf(a.b).inverse() * poseOf(b.b);
  const Pose off = expected.inverse() * b.T_a_b;
  return off.translation().norm() < config_.agree_distance && turnOf(off) < config_.agree_turn;
}

std::vector<VerifiedLoop> LoopAgreement::agreeingWithNewest(const KeyframeGraph& keyframes) const {
  std::vector<VerifiedLoop> agreeing;
  for (std::size_t k = 0; k + 1 < loops_.size(); ++k) {
    const BetweenConstraint &loop = loops_[k].loop, &newest = loops_.back().loop;
    if (newest.b - loop.b <= kLately && agree(keyframes, loop, newest)) {
      agreeing.push_back(loops_[k]);
    }
  }
  return agreeing;
}

std::vector<VerifiedLoop> LoopAgreement::overruling(const KeyframeGraph& keyframes) const {
  if (loops_.size() < kOverruling) {
    return {};
  }
  std::vector<VerifiedLoop> newest(loops_.end() - kOverruling, loops_.end());
  for (std::size_t i = 0; i < newest.size(); ++i) {
    for (std::size_t j = i + 1; j < newest.size(); ++j) {
      const BetweenConstraint &a = newest[i].loop, &b = newest[j].loop;
      if (std::abs(a.b - b.b) > kLately || !agree(keyframes, a, b)) {
        return {};
      }
    }
  }
  return newest;
}

Loosening looseningFor(const std::vector<VerifiedLoop>& loops) {
  Loosening loosening{loops.front().loop.a, loops.front().loop.b, 1};
  for (const VerifiedLoop& verified : loops) {
    loosening.from = std::max(loosening.from, verified.loop.a);
    loosening.to = std::min(loosening.to, verified.loop.b);
    loosening.factor = std::max(loosening.factor, verified.deviations);
  }
  return loosening;
}

}  // namespace hgg
