#pragma once

#include <deque>
#include <vector>

#include "correction/loop_closure.h"
#include "map/keyframes.h"

namespace hgg {

/// A loop whose places were recognised, whether or not the belief about the keyframes allows it.
struct VerifiedLoop {
  BetweenConstraint loop;
  double deviations = 0;  // LoopVerification
};

/// The last loops that were recognised and are not in the map yet. One alone may be a mistake: two places can look
/// alike. Loops that say the same of how the keyframes lie are no coincidence.
class LoopAgreement {
 public:
  explicit LoopAgreement(const LoopConfig& config) : config_(config) {}

  void add(const VerifiedLoop& loop);
  /// The loops added before the newest one that agree with it: the way through the keyframes from one to the other
  /// closes within the bounds of the config. Only loops of late are asked, because that way drifts.
  std::vector<VerifiedLoop> agreeingWithNewest(const KeyframeGraph& keyframes) const;
  /// Whether the newest loop overrules what is believed of the keyframes: it and two others agree, each with each, and
  /// none of late says otherwise. Returns them, the newest last; else nothing.
  std::vector<VerifiedLoop> overruling(const KeyframeGraph& keyframes) const;
  void clear() { loops_.clear(); }

 private:
  bool agree(const KeyframeGraph& keyframes, const BetweenConstraint& a, const BetweenConstraint& b) const;

  LoopConfig config_;
  std::deque<VerifiedLoop> loops_;  // oldest first
};

/// How the chain of keyframes has to be loosened so that loops which overrule it fit: every constraint between the
/// places they connect was wrong by as much as the loops are off.
Loosening looseningFor(const std::vector<VerifiedLoop>& loops);

}  // namespace hgg
